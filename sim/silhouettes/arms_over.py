"""Closed-form arms over time: `sim.person.kinematics.solve_arm` for F moments at once."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pjpdaf.arrays import Floats
from sim.anatomy import Anatomy
from sim.person.elbow_circles import ElbowCircles, elbow_circles, within_reach_over
from sim.person.kinematics import FARTHEST_BACK, MAX_SWIVEL_RAD, MAX_WRIST_BEND_RAD
from sim.vectors import dots

_UP = np.array([0.0, 0.0, 1.0])
_BEND_LIMIT_RAD = MAX_WRIST_BEND_RAD + 1e-4


@dataclass(frozen=True, eq=False)
class ArmsOver:
    """An arm over F moments: joints (F, 3) [m], hand (F, 3, 3) -> world."""

    shoulder_m: Floats
    elbow_m: Floats
    wrist_m: Floats
    palm_m: Floats
    hand: Floats


def arms_over(
    anatomy: Anatomy,
    side: int,
    shoulder_m: Floats,
    palm_m: Floats,
    hand: Floats,
    swivel_rad: Floats,
    elbow_above_m: Floats,
    forward: Floats,
) -> ArmsOver:
    """The arms whose palms are at palm_m (F, 3); arguments as of `solve_arm`, with F in front."""
    hand = hand.copy()
    wrist, elbow = _elbow(
        anatomy, side, shoulder_m, palm_m, hand, swivel_rad, elbow_above_m, forward
    )
    for _ in range(5):
        fore = (wrist - elbow) / anatomy.forearm_m
        bend = np.arccos(np.clip(dots(fore, hand[:, :, 0]), -1.0, 1.0))
        far = np.flatnonzero(bend > _BEND_LIMIT_RAD)
        if not len(far):
            break
        axis = np.cross(hand[far, :, 0], fore[far])
        axis /= np.linalg.norm(axis, axis=1, keepdims=True)
        hand[far] = _about(axis, bend[far] - MAX_WRIST_BEND_RAD) @ hand[far]
        wrist[far], elbow[far] = _elbow(
            anatomy,
            side,
            shoulder_m[far],
            palm_m[far],
            hand[far],
            swivel_rad[far],
            elbow_above_m[far],
            forward[far],
        )
    return ArmsOver(shoulder_m, elbow, wrist, wrist + anatomy.wrist_to_palm_m * hand[:, :, 0], hand)


def _elbow(
    anatomy: Anatomy,
    side: int,
    shoulder_m: Floats,
    palm_m: Floats,
    hand: Floats,
    swivel_rad: Floats,
    elbow_above_m: Floats,
    forward: Floats,
) -> tuple[Floats, Floats]:
    """Wrists within reach, and elbows, (F, 3) each."""
    a, b = anatomy.upper_arm_m, anatomy.forearm_m
    wrist = within_reach_over(shoulder_m, palm_m - anatomy.wrist_to_palm_m * hand[:, :, 0], a, b)
    circles = elbow_circles(side, shoulder_m, wrist, a, b)
    behind = dots(shoulder_m, forward) - a * FARTHEST_BACK
    swivel = np.maximum(
        swivel_rad, _least_swivel(circles, np.array([0.0, 0.0, 1.0]), elbow_above_m)
    )
    swivel = np.maximum(swivel, _least_swivel(circles, forward, behind))
    return wrist, circles.elbows(np.cos(swivel), np.sin(swivel))


def _least_swivel(circles: ElbowCircles, way: Floats, level: Floats) -> Floats:
    """`ElbowCircle.least_swivel_towards` (F,)."""
    a = circles.radius_m * dots(circles.down, way)
    b = circles.radius_m * dots(circles.outward, way)
    need = level - dots(circles.centre_m, way)
    size = np.hypot(a, b)
    phase = np.arctan2(b, a) % (2.0 * math.pi)
    share = np.clip(need / np.maximum(size, 1e-300), -1.0, 1.0)
    crossing = np.where(need < size, phase - np.arccos(share), phase)
    return np.where(a >= need, 0.0, np.clip(crossing, 0.0, MAX_SWIVEL_RAD))


def _about(axis: Floats, angle: Floats) -> Floats:
    """Rotations (F, 3, 3) about unit axes (F, 3) (Rodrigues)."""
    c, s = np.cos(angle)[:, None, None], np.sin(angle)[:, None, None]
    x, y, z = axis.T
    zero = np.zeros_like(x)
    skew = np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=1).reshape(-1, 3, 3)
    outer = axis[:, :, None] * axis[:, None, :]
    return np.asarray(c * np.eye(3) + s * skew + (1.0 - c) * outer)
