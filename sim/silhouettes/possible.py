"""Moments at which a person can surely be as a plan has them: most, and cheaply known.

What is left is judged moment by moment (`sim.motion.measure.fault_of`), which takes ten times as
long.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from pjpdaf.arrays import Bools, Floats
from sim.contact.solids import StandingObject
from sim.motion.measure import ALLOWED_SHORT_M, GREATEST_ANGLES, standing_objects
from sim.motion.motion import Performer
from sim.person.kinematics import MAX_STRETCH, OUTWARD
from sim.silhouettes.arms_over import ArmsOver
from sim.silhouettes.contact_over import ArmShapes
from sim.silhouettes.planned_arms import planned_arms
from sim.vectors import dots

_CLOSE = 1e-6  # nearer to a limit than this is left to the exact judgement: rounding differs


def surely_possible(performer: Performer, times_s: Sequence[float]) -> Bools:
    """Whether nothing is near a fault of `fault_of` at these times (F,); speeds are not judged.

    True less often than might be, never more.
    """
    planned = planned_arms(performer, times_s)
    anatomy = performer.scene.anatomy
    objects = standing_objects(performer)
    fine = ~planned.may_touch
    for side, (arm, palms_m) in enumerate(zip(planned.arms, planned.palms_m, strict=True)):
        fine &= _within_limits(side, arm, planned.torso[1])
        reach = np.linalg.norm(arm.wrist_m - arm.shoulder_m, axis=1)
        fine &= reach / (anatomy.upper_arm_m + anatomy.forearm_m) <= MAX_STRETCH + 0.5 * _CLOSE
        fine &= np.linalg.norm(palms_m - arm.palm_m, axis=1) <= ALLOWED_SHORT_M - _CLOSE
        for standing in objects:
            fine &= ~_near(planned.shapes[side], standing)
    return fine


def _within_limits(side: int, arm: ArmsOver, torso: Floats) -> Bools:
    """Whether all joints are inside their range (F,)."""
    most = {joint: angle - _CLOSE for joint, angle in GREATEST_ANGLES.items()}
    fore, upper = _unit(arm.wrist_m - arm.elbow_m), _unit(arm.elbow_m - arm.shoulder_m)
    backward = -dots(upper, torso[:, :, 0])
    across = -OUTWARD[side] * dots(upper, torso[:, :, 1])
    return np.asarray(
        (dots(fore, arm.hand[:, :, 0]) >= math.cos(most["wrist bends"]))
        & (dots(upper, fore) >= math.cos(most["elbow bends"]))
        & (backward <= math.sin(most["upper arm goes backward"]))
        & (across <= math.sin(most["upper arm goes across the body"]))
    )


def _unit(vectors: Floats) -> Floats:
    return np.asarray(vectors / np.linalg.norm(vectors, axis=1, keepdims=True))


def _near(shapes: ArmShapes, standing: StandingObject) -> Bools:
    """Whether a point of the arm may be in the upright cylinder around an object (F,)."""
    sx, sy, sz = standing.size_m
    local, radii = shapes.points_m - standing.base_m, shapes.point_radii_m
    aside = np.hypot(local[..., 0], local[..., 1]) < 0.5 * math.hypot(sx, sy) + radii
    level = (local[..., 2] > -radii) & (local[..., 2] < sz + radii)
    return np.asarray((aside & level).any(axis=1))
