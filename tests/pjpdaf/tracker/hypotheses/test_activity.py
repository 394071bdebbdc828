"""What motion says of the names of hands that move fast."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from pjpdaf.tracker.hypotheses.activity import share_of_motion, speed_after, tempered
from pjpdaf.tracker.hypotheses.hypothesis import Hypothesis, Sightings, grow
from pjpdaf.tracker.hypotheses.pairs import Pairs
from pjpdaf.tracker.hypotheses.parameters import HypothesisParameters, MotionParameters

P = HypothesisParameters()
M = MotionParameters(naming_step_m=0.08, speed_memory_s=0.3)
FRAME_S = 1 / 3
PLACES = np.array([[-0.1, 0.0, 1.2], [0.1, 0.0, 1.2]])
FACE = np.array([0.0, -0.5, 1.3])
SEEN = np.array([True, True])


def test_motion_counts_half_at_the_step_and_in_full_at_rest():
    assert share_of_motion([0.0], [0.0], 1.0, FRAME_S, M) == 1.0
    assert share_of_motion([0.08 / FRAME_S], [0.0], 1.0, FRAME_S, M) == pytest.approx(0.5)
    off = dataclasses.replace(M, naming_step_m=0.0)
    assert share_of_motion([2.0], [0.0], 1.0, FRAME_S, off) == 1.0
    assert share_of_motion([2.0], [0.0], 0.0, FRAME_S, M) == 1.0  # no sleeves


def test_all_hypotheses_share_the_speed_of_the_likely_ones():
    alone = share_of_motion([0.6], [0.0], 1.0, FRAME_S, M)
    assert share_of_motion([0.6, 5.0], [0.0, 40.0], 1.0, FRAME_S, M) == pytest.approx(alone)
    assert share_of_motion([0.0, 0.6], [0.0, 0.0], 1.0, FRAME_S, M) < 1.0


@pytest.mark.parametrize("rate", [3, 10, 30])
def test_the_speed_fades_alike_at_every_frame_rate(rate: int):
    speed, x = 1.0, np.zeros((2, 3))
    for _ in range(rate):
        speed = speed_after(speed, x, x, SEEN, 1 / rate, M.speed_memory_s)
    assert speed == pytest.approx(np.exp(-0.5 / M.speed_memory_s))


def test_a_hand_that_is_not_seen_has_no_speed():
    before, after = np.zeros((2, 3)), np.array([[0.3, 0.0, 0.0], [0.0, 0.0, 0.0]])
    unseen = np.array([False, False])
    assert speed_after(0.7, before, after, unseen, FRAME_S, 0.3) == 0.7
    one = speed_after(0.0, before, after, np.array([True, False]), FRAME_S, 0.3)
    assert one > speed_after(0.0, before, after, SEEN, FRAME_S, 0.3) > 0.0


def test_only_what_a_naming_costs_beyond_the_other_is_tempered():
    each = np.random.default_rng(3).uniform(0.0, 16.0, (4, 2, 5))
    points = np.random.default_rng(4).normal([0.0, 0.0, 1.2], 0.05, (5, 3))
    plain = each[:, 0, :, None] + each[:, 1, None, :]
    costs = tempered(each, points, FACE, 0.25)
    other = plain.swapaxes(1, 2)
    np.testing.assert_allclose(costs - costs.swapaxes(1, 2), 0.25 * (plain - other), atol=1e-12)
    np.testing.assert_allclose(np.minimum(costs, costs.swapaxes(1, 2)), np.minimum(plain, other))
    np.testing.assert_array_equal(tempered(each, points, FACE, 1.0), plain)
    # At the head motion counts in full.
    np.testing.assert_array_equal(tempered(each, points, points[0] + 0.01, 0.25)[:, 0], plain[:, 0])


def named(speed_mps: float, odds: float, p: HypothesisParameters = P) -> bool:
    """Whether hands that a sleeve's odds say changed places are taken to have done so."""
    C = np.tile(np.eye(3) * 0.015**2, (2, 1, 1))
    number = np.array([[0, 0], [1, 1]])
    pairs = Pairs(
        PLACES, C, np.full(2, 0.011), np.zeros(2), number, np.zeros((2, 2), np.intp), number
    )
    sightings = Sightings(
        pairs,
        np.zeros(2),
        # Each place is one hand's, and both want an owner.
        np.where(np.array([[0, 1, 0, 0], [1, 0, 0, 0], [0, 0, 1, 1], [0, 0, 1, 1]]) > 0, 0.0, 20.0),
        np.array([-odds, odds]),
        FACE[None],
        np.array([30.0]),
        np.zeros((2, 2, 3)),
    )
    # The left of the picture is the right hand's: it was at the first place.
    before = Hypothesis(0.0, 0.0, PLACES, C, np.zeros(2), speed_mps=speed_mps)
    after, _ = grow((before,), sightings, FRAME_S, p)
    means = after[0].means
    return bool(np.linalg.norm(means - PLACES[::-1]) < np.linalg.norm(means - PLACES))


def test_sleeves_name_hands_that_roll_and_motion_those_that_rest():
    assert named(0.6, 3.0)
    assert not named(0.0, 3.0)
    assert not named(0.6, -3.0)
    off = dataclasses.replace(P, motion=dataclasses.replace(P.motion, naming_step_m=0.0))
    assert not named(0.6, 3.0, off)
