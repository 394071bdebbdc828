"""What motion says for the names of two hands that are found where two hands were."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pjpdaf.tracker.hypotheses.change_places import both_hands
from pjpdaf.tracker.hypotheses.parameters import MotionParameters

FRAME_S = 1 / 3
M = MotionParameters()
HANDS_M = np.array([[[0.4, -0.05, 0.9], [0.4, 0.05, 0.9]]])
FACE_M = np.array([0.1, 0.0, 1.2])
# Two places where the hands were: to stay costs nothing, to change places 9 for each hand.
EACH = np.array([[[0.0, 9.0], [9.0, 0.0]]])
STAY, CHANGE = (0, 0, 1), (0, 1, 0)


def test_near_hands_may_have_changed_places():
    cost = both_hands(EACH, HANDS_M, FACE_M, 2, FRAME_S, M)
    assert cost[STAY] == 0.0
    fast = 0.5 * (0.1 / max(M.deviations_m)) ** 2
    assert cost[CHANGE] == pytest.approx(M.exchange_cost + fast)


def test_without_the_bound_motion_says_what_it_says():
    cost = both_hands(EACH, HANDS_M, FACE_M, 2, FRAME_S, replace(M, exchange_cost=0.0))
    np.testing.assert_allclose(cost, [[[9.0, 0.0], [18.0, 9.0]]])


@pytest.mark.parametrize(("apart_m", "dt_s"), [(1.6, FRAME_S), (0.16, FRAME_S / 10)])
def test_hands_that_are_far_for_the_time_have_not(apart_m, dt_s):
    far = np.array([[[0.4, 0.0, 0.9], [0.4, apart_m, 0.9]]])
    plain = EACH[:, 0, :, None] + EACH[:, 1, None, :]
    assert both_hands(EACH, far, FACE_M, 2, dt_s, M)[CHANGE] > 12.0
    np.testing.assert_array_equal(both_hands(EACH, far, FACE_M, 2, dt_s, M)[STAY], plain[STAY])


def test_what_was_not_seen_and_hands_at_the_head_keep_their_names():
    plain = both_hands(EACH, HANDS_M, FACE_M, 2, FRAME_S, replace(M, exchange_cost=0.0))
    at_head = HANDS_M - HANDS_M.mean(axis=1) + FACE_M
    np.testing.assert_array_equal(both_hands(EACH, at_head, FACE_M, 2, FRAME_S, M), plain)
    np.testing.assert_array_equal(both_hands(EACH, HANDS_M, FACE_M, 1, FRAME_S, M), plain)
