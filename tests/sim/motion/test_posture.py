"""Posture: torso and head for what the hands do."""

from __future__ import annotations

import numpy as np
from performances import performance

from sim.motion.carriage import Carriage
from sim.motion.posture import posture, shoulders_over
from sim.motion.strokes import HandState
from sim.person.kinematics import shoulders


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


def test_shoulders_of_many_carriages_are_those_of_each():
    anatomy = performance("cross", 0).scene.anatomy
    turns = np.random.default_rng(0).normal(0.0, 0.3, (100, 3))
    at_rest = HandState(np.array([0.3, 0.0, 0.8]), np.array([1.0, 0, 0, 0]), np.zeros(5))
    for joints, turn in zip(shoulders_over(anatomy, turns), turns, strict=True):
        torso, _ = posture(anatomy, (at_rest, at_rest), np.zeros(3), Carriage(*turn.tolist()))
        expected = shoulders(anatomy, torso.position_m, torso.rotation)
        np.testing.assert_array_equal(joints, expected)
