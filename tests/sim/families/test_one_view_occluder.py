"""A post between a hand and one of the cameras."""

from __future__ import annotations

import numpy as np
import pytest
from performances import HANDS, cues, drawn, fractions, frame_times, performance

from pjpdaf.errors import BenchError
from pjpdaf.targets import HEAD

SEEDS = range(200, 203)
CAMERAS = ("left", "right")


def test_the_post_hides_the_hand_in_one_view_alone_for_2_to_12_frames(seed):
    played, values = performance("one_view_occluder", seed), drawn("one_view_occluder", seed)
    lost, hand = CAMERAS.index(values["view"]), 1 + HANDS.index(values["hand"])
    first = cues(played, "hidden:")[0]
    assert first.name == f"hidden:{values['view']}_view"
    seen = fractions(played, frame_times(played, first.from_s - 1.0, first.to_s + 1.0))
    hidden = seen[:, lost, hand] < 0.1
    assert 2 <= hidden.sum() <= 12
    assert (np.diff(np.flatnonzero(hidden)) == 1).all()
    # Never the other view, the other hand, or the head.
    assert seen[:, 1 - lost, hand].min() > 0.7
    assert seen[:, :, 3 - hand].min() > 0.9
    assert seen[:, :, HEAD].min() > 0.97
    assert seen[-1, lost, hand] > 0.7
    at_start = fractions(played, [0.0])
    assert at_start.min() > 0.7


@pytest.mark.long
@pytest.mark.parametrize(("hidden", "frames"), [(0.6, 2), (3.8, 12)])
def test_both_ends_of_the_time_behind_the_post_are_2_and_12_frames(hidden, frames):
    played = performance("one_view_occluder", 200, hidden=hidden)
    values = drawn("one_view_occluder", 200)
    cue = cues(played, "hidden:")[0]
    seen = fractions(played, frame_times(played, cue.from_s - 0.7, cue.to_s + 0.7))
    hand = 1 + HANDS.index(values["hand"])
    count = (seen[:, CAMERAS.index(values["view"]), hand] < 0.1).sum()
    assert abs(count - frames) <= 1


@pytest.mark.long
@pytest.mark.parametrize("hand", HANDS)
@pytest.mark.parametrize("view", CAMERAS)
def test_either_hand_is_hidden_from_either_camera(hand, view):
    played = performance("one_view_occluder", 203, hand=hand, view=view)
    cue = cues(played, "hidden:")[0]
    seen = fractions(played, [0.5 * (cue.from_s + cue.to_s)])[0, :, 1 + HANDS.index(hand)]
    assert seen[CAMERAS.index(view)] < 0.1
    assert seen[1 - CAMERAS.index(view)] > 0.7


def test_the_post_is_3_to_5_cm_wide_and_stands_on_the_table_near_the_rig(seeds):
    for seed in seeds:
        scene = performance("one_view_occluder", seed).scene
        (post,) = scene.room.objects
        assert post.kind == "post"
        assert 0.03 <= post.size_m[0] <= 0.05
        assert 0.4 <= scene.rig.distance_m - post.position_xy_m[0] <= 0.7
        assert post.base_m is None
        far = scene.room.table_near_x_m + scene.room.table_depth_m
        assert post.position_xy_m[0] + 0.05 <= far


def test_a_post_that_does_not_fit_on_the_table_stands_on_the_floor():
    scene = performance("one_view_occluder", 200, rig_distance=1.5, post_distance=0.5).scene
    (post,) = scene.room.objects
    assert post.base_m == 0.0
    assert post.size_m[2] > scene.room.table_height_m


def test_a_post_behind_the_hand_is_refused():
    fault = "the hand at centre_x 0.46 m is not behind the post at 0.4 m: lower centre_x or"
    with pytest.raises(BenchError, match=fault):
        performance("one_view_occluder", 200, rig_distance=1.1, post_distance=0.7, centre_x=0.46)
