"""Elbow circles of many arms, against those of one arm at a time: the same bits."""

from __future__ import annotations

import numpy as np
import pytest

from sim.anatomy import Anatomy
from sim.person.elbow_circles import elbow_circles, within_reach_over
from sim.person.kinematics import elbow_circle, within_reach

PERSON = Anatomy.of(1.72)
SIZES = PERSON.upper_arm_m, PERSON.forearm_m


@pytest.mark.parametrize("side", [0, 1])
def test_each_arm_is_solved_as_alone(side):
    rng = np.random.default_rng(side)
    shoulders = np.array([0.0, -0.186, 0.994]) + rng.normal(0.0, 0.1, (300, 3))
    wrists = shoulders + rng.normal(0.0, 0.4, (300, 3))
    wrists[0] = shoulders[0]  # no direction
    wrists[1] = shoulders[1] + [0.0, 0.3, 0.0]  # along what stands in for down
    heights = rng.uniform(0.6, 1.0, 300)
    within = within_reach_over(shoulders, wrists, *SIZES)
    circles = elbow_circles(side, shoulders, within, *SIZES)
    least = circles.least_swivels(heights)
    elbows = circles.elbows(np.zeros(300), np.ones(300))
    for k in range(300):
        alone = within_reach(shoulders[k], wrists[k], *SIZES)
        np.testing.assert_array_equal(within[k], alone)
        circle = elbow_circle(side, shoulders[k], alone, *SIZES)
        for field in ("centre_m", "radius_m", "down", "outward"):
            np.testing.assert_array_equal(getattr(circles, field)[k], getattr(circle, field))
        assert least[k] == circle.least_swivel(heights[k])
        np.testing.assert_allclose(elbows[k], circle.elbow(np.pi / 2), atol=1e-15)
    assert 0.1 < np.mean(least > 0.0) < 0.9
