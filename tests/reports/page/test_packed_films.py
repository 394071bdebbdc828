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


ORDER = [("a", 2), ("a", 0), ("a", 1), ("b", 0)]


def frames(places):
    return {key: len(place.film.pictures) for (_, key), place in places.items() if place.film}


def test_films_go_in_as_far_as_there_is_room(filmed):
    whole = packed_films([filmed], [ORDER])
    assert frames(whole) == {("a", 2): 10, ("a", 0): 10, ("a", 1): 10, ("b", 0): 2}
    assert whole[0, ("a", 2)].film.sizes.startswith("0:100 1:100 ")
    assert [place.film.whole for place in whole.values()] == [True, True, True, False]
    # The last is thinned to the room that is left, or left out where that is next to nothing.
    thinned = packed_films([filmed], [ORDER], 1600)
    assert frames(thinned) == {("a", 2): 10, ("a", 0): 6}
    assert list(thinned[0, ("a", 0)].film.pictures)[::5] == [0, 9]
    assert not thinned[0, ("a", 0)].film.whole
    assert frames(packed_films([filmed], [ORDER], 1100)) == {("a", 2): 10}
    assert packed_films([filmed], [ORDER], 50) == {}


def test_the_same_pictures_of_two_runs_are_there_once(filmed):
    places = packed_films([filmed, filmed], [ORDER, ORDER[::-1]], 2300)
    assert {(at, len(place.film.pictures)) for at, place in places.items() if place.film} == {
        ((0, ("a", 2)), 10),
        ((1, ("b", 0)), 2),
        ((0, ("a", 0)), 10),
    }
    assert places[1, ("a", 2)].owner == (0, ("a", 2))
    assert places[0, ("b", 0)].owner == (1, ("b", 0))
