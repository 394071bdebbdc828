"""Frames chosen for sheets and pictures."""

import numpy as np
import pytest
from made_truth import truth

from scenarios.catalogue.frame_choice import (
    difficulty,
    hardest_frame,
    representative_frames,
    truths_without_pictures,
)
from scenarios.spec.draw import perform
from scenarios.spec.names import load_scenario
from sim.sequence import Simulation


@pytest.mark.parametrize("seed", range(5))
def test_the_frames_of_a_sheet_are_spread_and_miss_no_merge(seed):
    rng = np.random.default_rng(seed)
    starts = rng.integers(5, 25, 3) + np.array([0, 30, 60])
    inside = {i for start in starts for i in range(start, start + 4)}
    seen = [truth(i, merged=int(i in inside)) for i in range(100)]
    chosen = representative_frames(seen, 12)
    assert len(chosen) == 12
    assert chosen == sorted(set(chosen))
    assert chosen[0] == 0
    assert all(set(range(start, start + 4)) & set(chosen) for start in starts)
    assert np.diff([*chosen, 100]).max() < 30


def test_few_frames_are_all_on_the_sheet_and_many_events_leave_the_hard_ones():
    assert representative_frames([truth(i) for i in range(5)], 12) == [0, 1, 2, 3, 4]
    seen = [truth(i, events=(f"step:{i}",), merged=int(i in (50, 70))) for i in range(100)]
    assert {50, 70} <= set(representative_frames(seen, 12))


def test_the_hardest_frame_is_in_the_middle_of_the_hardest_stretch():
    seen = [truth(i, events=("reach",) * (5 <= i < 30)) for i in range(40)]
    assert hardest_frame(seen).index == 17
    seen[8:11] = [truth(i, merged=1) for i in range(8, 11)]
    seen[20:25] = [truth(i, merged=1) for i in range(20, 25)]
    assert hardest_frame(seen).index == 22
    seen[33] = truth(33, merged=1, visible=0)
    assert hardest_frame(seen).index == 33
    assert hardest_frame([truth(i) for i in range(9)]).index == 4


def test_truths_without_pictures_are_those_of_the_simulation():
    performance = perform(load_scenario("cross"), 100)
    quick = list(truths_without_pictures(performance, (0, 14)))
    with Simulation(performance) as simulation:
        for picture_free in quick:
            full = simulation.render(picture_free.index).truth
            np.testing.assert_array_equal(picture_free.centres_m, full.centres_m)
            assert picture_free.events == full.events
            for a, b in zip(picture_free.views, full.views, strict=True):
                np.testing.assert_array_equal(a.visible_px, b.visible_px)
                np.testing.assert_array_equal(a.merged, b.merged)
    assert difficulty(quick[0]) == 0
    assert not [name for name in quick[1].script_events if "merge" in name]
