"""Films of the page, within their room."""

from dataclasses import replace

import pytest

from reports.page.packed_films import packed_films
from reports.run.load import load
from reports.run.save import RunInfo, save
from reports.score.records import Still


@pytest.fixture(scope="module")
def filmed(episode_of, tools, tmp_path_factory):
    """A good and two bad episodes, each with all its frames; a good one with two frames."""
    centres = tools.paths(10, 3.0)
    webp = b"RIFF" + bytes(96)
    every = tuple(Still(f, webp) for f in range(10))

    def episode(estimates, film, **changes):
        return replace(episode_of(estimates, centres_m=centres, **changes), film=film)

    good = tools.noisy(centres, 0, 0.005)
    bad = good.copy()
    bad[2:, 1] += 0.4
    return load(
        save(
            tmp_path_factory.mktemp("filmed") / "run",
            [
                episode(good, every, scenario="a"),
                episode(good, every, scenario="a", seed=1),
                episode(bad, every, scenario="a", seed=2),
                episode(good, every[::5], scenario="b"),
            ],
            RunInfo("run"),
        )
    )


def test_films_are_kept_of_first_seeds_and_of_what_went_wrong(filmed):
    kept = [(film["scenario"], film["seed"], film["whole"]) for film in filmed.meta["films"]]
    assert kept == [("a", 0, True), ("a", 2, True), ("b", 0, False)]


def test_films_go_in_as_far_as_there_is_room(filmed):
    order = [("a", 2), ("a", 0), ("b", 0)]
    all_of_it = packed_films(filmed, order, (10_000, 10_000))
    assert [len(f.pictures) for f in all_of_it.values()] == [10, 10, 2]
    assert all_of_it["a", 2].sizes.startswith("0:100 1:100 ")
    assert list(packed_films(filmed, order, (1500, 10_000))) == [("a", 2), ("b", 0)]
    assert [len(f.pictures) for f in packed_films(filmed, order, (0, 150)).values()] == [1]
    assert packed_films(filmed, order, (0, 50)) == {}
