"""Costs of two choices together."""

from __future__ import annotations

import numpy as np
import pytest

from pjpdaf.tracker.hypotheses.candidates import END, HALF, OTHER_END, OTHER_HALF
from pjpdaf.tracker.hypotheses.costs import joint_cost
from pjpdaf.tracker.hypotheses.pairs import Pairs
from pjpdaf.tracker.hypotheses.parameters import CostParameters

PARTS = END, OTHER_END, HALF, OTHER_HALF


def one_blob() -> Pairs:
    """The sightings of two bare arms that meet: both ends, both middles, in both views."""
    n = len(PARTS)
    part = np.repeat(np.array(PARTS)[:, None], 2, axis=1)
    number = np.repeat(np.arange(n)[:, None], 2, axis=1)
    points, each = np.zeros((n, 3)), np.tile(np.eye(3), (n, 1, 1))
    areas, none = np.full(n, 0.008), np.zeros(n)
    return Pairs(points, each, areas, none, 0 * number, part, number)


@pytest.mark.parametrize("cost", [0.0, 4.0])
def test_a_hand_at_the_elbow_and_one_in_the_middle_of_two_arms(cost):
    joint = joint_cost(one_blob(), (None, None), 0.011, CostParameters(end_and_half=cost))
    assert joint[2, 3] == joint[3, 2] == 0.0
    np.testing.assert_allclose(joint[:2, 2:4], cost)
    np.testing.assert_allclose(joint[2:4, :2], cost)
