"""A hand that leaves the picture of one camera, then of both."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from performances import HANDS, cues, drawn, fractions, frame_times, performance, truths

from pjpdaf.errors import BenchError
from sim.families import leave_view as family
from sim.scene.rig import stereo_rig
from sim.specs import RigSpec

SEEDS = range(200, 203)
CAMERAS = ("left", "right")


@pytest.mark.long
def test_a_hand_leaves_one_view_first_and_both_for_1_to_6_frames(seed):
    played, values = performance("leave_view", seed), drawn("leave_view", seed)
    side = HANDS.index(values["hand"])
    one, out = cues(played, "out")
    times = frame_times(played, one.from_s - 0.8, out.to_s + 1.8)
    seen = fractions(played, times)[:, :, 1 + side]
    gone = np.isnan(seen) | (seen < 0.05)
    both = gone.all(axis=1)
    assert 1 <= both.sum() <= 6
    # The camera on the other side loses it first, and sees it last.
    first = 1 - side
    assert gone[:, first].sum() > gone[:, 1 - first].sum()
    assert np.argmax(gone[:, first]) < np.argmax(gone[:, 1 - first])
    assert not gone[0].any()
    assert not gone[-1].any()


def test_where_it_left_the_first_view_the_second_still_shows_the_hand(seeds):
    for seed in seeds:
        played, values = performance("leave_view", seed), drawn("leave_view", seed)
        side = HANDS.index(values["hand"])
        one = cues(played, "out:")[0]
        assert one.name == f"out:{CAMERAS[1 - side]}_view"
        (views,) = truths(played, [one.from_s + 0.01])
        assert views[1 - side].visible_px[1 + side] == 0
        assert views[side].visible_px[1 + side] > 300


def test_a_picture_that_no_hand_can_leave_is_refused():
    played = performance("leave_view", 200)
    state = played.script.plan.hands[0].at(0.0)
    cameras = stereo_rig(replace(RigSpec(), focal_px=100.0)).cameras
    with pytest.raises(BenchError, match="too wide for a hand to leave it: raise focal, or lower"):
        family._way_out(cameras, played.scene.anatomy, 0, state, np.array([0.0, -1.0, 0.0]), 5.0)
