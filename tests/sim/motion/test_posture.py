"""Posture: torso and head for what the hands do."""

from __future__ import annotations

import numpy as np
from performances import performance

from sim.motion.posture import posture
from sim.motion.strokes import HandState


def test_the_torso_leans_where_an_arm_would_be_stretched():
    anatomy = performance("cross", 0).scene.anatomy
    near, far = (
        [
            HandState(np.array([x, y, 0.8]), np.array([1.0, 0, 0, 0]), np.zeros(5))
            for y in (-0.2, 0.2)
        ]
        for x in (0.35, 0.75)
    )
    upright, _ = posture(anatomy, (near[0], near[1]), np.zeros(3))
    leant, head = posture(anatomy, (far[0], near[1]), np.zeros(3))
    assert abs(upright.position_m[0]) < 0.002
    assert 0.05 < leant.position_m[0] < 0.17
    assert head.position_m[0] > leant.position_m[0]
