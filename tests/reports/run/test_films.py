"""Films of a run: chosen in any order, kept whole, read back, checked."""

import itertools
from dataclasses import replace

import pytest

from pjpdaf.errors import BenchError
from reports.run.films import FilmShelf, films_to_keep
from reports.run.load import load, read_film
from reports.run.rows import rows_of
from reports.score.records import Still


@pytest.fixture(scope="module")
def filmed(episode_of, tools):
    """Rows of five episodes, seeds 1 and 3 of which go wrong, 3 more so; films of 100 bytes."""
    centres = tools.paths(10, 3.0)
    rows = []
    for seed, off_m in enumerate((0.0, 0.2, 0.0, 0.4, 0.0)):
        estimates = centres.copy()
        estimates[5 - seed :, 1] += off_m
        played = episode_of(estimates, centres_m=centres, scenario="a", seed=seed)
        rows.append(replace(rows_of(played), film=(Still(0, bytes(60)), Still(5, bytes(40)))))
    return rows


def test_what_went_wrong_is_kept_first_and_then_the_first_seeds(filmed):
    assert [films_to_keep(filmed, 100 * n) for n in range(6)] == [
        set(),
        {3},
        {1, 3},
        {0, 1, 3},
        {0, 1, 2, 3},
        {0, 1, 2, 3, 4},
    ]


def test_the_choice_does_not_depend_on_the_order_in_which_episodes_end(filmed):
    for order in itertools.permutations(range(5)):
        # After two episodes the run is interrupted and goes on with what its journal has.
        shelf, dropped = FilmShelf(250), set()
        for index in order[:2]:
            dropped.update(shelf.add(index, filmed[index]))
        shelf, gone = FilmShelf(250), set(dropped)
        for index in order[:2]:
            row = filmed[index]
            dropped.update(shelf.close(row) if index in gone else shelf.add(index, row))
        for index in order[2:]:
            dropped.update(shelf.add(index, filmed[index]))
        assert set(range(5)) - dropped == {1, 3}, order


def test_films_are_kept_whole_and_checked(run):
    read = load(run)
    kept = [(film["scenario"], film["seed"], film["frames"]) for film in read.meta["films"]]
    assert kept == [(name, seed, 3) for name in ("calm_table", "cross") for seed in range(3)]
    assert not any(film["whole"] for film in read.meta["films"])
    film = read.meta["films"][4]["file"]
    assert read_film(read, film) == {f: f"RIFF 1 {f}".encode() for f in (0, 3, 11)}
    (run / film).write_bytes(b"PK")
    with pytest.raises(BenchError, match=r"0004_cross_1\.zip: is damaged"):
        read_film(read, film)
    with pytest.raises(BenchError, match=r"0004_cross_1\.zip: is damaged"):
        load(run)
