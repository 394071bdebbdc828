"""Carriage motions: leaning there and back, without a jump."""

from __future__ import annotations

import numpy as np
import pytest

from sim.motion.carriage import NEUTRAL, UPRIGHT, Lean, Leans


def angles(motion, t_s):
    held = motion.at(t_s)
    return np.array([held.forward_rad, held.sideways_rad, held.turn_rad])


def test_a_lean_is_whole_between_there_and_leave_and_gone_outside():
    lean = Lean(1.0, 2.0, 4.0, 5.0, forward_rad=0.3, sideways_rad=-0.2)
    for t in (0.0, 1.0, 5.0, 9.0):
        assert not angles(lean, t).any()
    for t in (2.0, 3.0, 4.0):
        np.testing.assert_allclose(angles(lean, t), [0.3, -0.2, 0.0])


def test_leans_there_and_back_are_a_lean():
    lean = Lean(1.0, 2.0, 4.0, 5.5, forward_rad=0.3, sideways_rad=-0.2)
    leans = Leans(((1.0, 1.0, 0.3, -0.2, 0.0), (4.0, 1.5, 0.0, 0.0, 0.0)))
    for t in np.linspace(0.0, 7.0, 60).tolist():
        np.testing.assert_allclose(angles(leans, t), angles(lean, t), atol=1e-15)


def test_upright_adds_nothing_at_any_time():
    assert UPRIGHT.at(-1.0) is UPRIGHT.at(7.0) is NEUTRAL
    assert angles(UPRIGHT, 3.0) == pytest.approx([0.0, 0.0, 0.0])
