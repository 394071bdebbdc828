"""Names of events: written and read by the same module."""

import math

import pytest

from sim.event_names import is_merge, merge_name, speed_name, stroke_speed_mps


@pytest.mark.parametrize("speed_mps", [0.1, 0.5, 1.0, 3.0])
def test_a_speed_is_read_back(speed_mps):
    assert stroke_speed_mps(speed_name(speed_mps)) == speed_mps


@pytest.mark.parametrize("name", ["grasp", "speed:fast", "speed:-1", "speed:0", "speed:nan", ""])
def test_other_names_have_no_speed(name):
    assert math.isnan(stroke_speed_mps(name))


def test_merges_are_known_by_their_name():
    assert merge_name("head", "left_hand", "right") == "merge:head+left_hand:right_view"
    assert is_merge(merge_name("head", "left_hand", "right"))
    assert not is_merge(speed_name(0.5))
