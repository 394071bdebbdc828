"""A hand under the table."""

from __future__ import annotations

import numpy as np
import pytest
from performances import HANDS, cues, drawn, end_s, fractions, frame_times, palms, performance

SEEDS = range(200, 203)
CAMERAS = ("left", "right")


@pytest.mark.long
def test_under_the_table_a_hand_is_hidden_in_both_views_for_1_to_8_s(seed):
    played, values = performance("hand_under_table", seed), drawn("hand_under_table", seed)
    side = HANDS.index(values["hand"])
    (cue,) = cues(played, "under_table")
    assert cue.to_s - cue.from_s == pytest.approx(values["under"])
    times = frame_times(played, cue.from_s - 1.4, cue.to_s + 1.4)
    gone = (fractions(played, times)[:, :, 1 + side] < 0.02).all(axis=1)
    assert 1.0 <= gone.sum() / played.fps <= 8.0
    assert gone[[cue.from_s <= t <= cue.to_s for t in times]].all()
    room = played.scene.room
    (under,) = palms(played.script, [0.5 * (cue.from_s + cue.to_s)])[:, side]
    assert under[0] > room.table_near_x_m
    assert under[2] < room.table_height_m - 0.06


@pytest.mark.long
def test_from_under_the_table_a_hand_comes_back_elsewhere():
    for seed in range(200, 210):
        played = performance("hand_under_table", seed)
        (cue,) = cues(played, "come_back")
        end = end_s(played)
        assert cue.to_s < end
        moved = np.linalg.norm(np.subtract(*palms(played.script, (0.0, end))), axis=1)
        assert 0.03 < max(moved) < 0.25
        assert min(moved) < 1e-9
