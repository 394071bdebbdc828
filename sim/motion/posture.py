"""Posture: where torso and head are, given both hands."""

from __future__ import annotations

import math

import numpy as np

from pjpdaf.arrays import Floats
from sim.anatomy import Anatomy
from sim.motion.carriage import NEUTRAL, Carriage
from sim.motion.strokes import HandState
from sim.person.kinematics import shoulders
from sim.pose import Transform
from sim.vectors import about_x, about_y, about_z, norm

_HIP_HEIGHT_H = 0.245  # of the stature: the pivot of the torso (seat height, as in `Anatomy.of`)
_HEAD_FORWARD_M = 0.02  # the head's centre stands ahead of the mid-shoulder point
_MAX_LEAN_RAD = math.radians(15.0)
_TORSO_SHARE = 0.4  # of the head's sway


def posture(
    anatomy: Anatomy,
    hands: tuple[HandState, HandState],
    sway_m: Floats,
    carriage: Carriage = NEUTRAL,
) -> tuple[Transform, Transform]:
    """Torso and head for these states of the hands (right, left), displaced by sway_m (3,).

    The torso leans forward, up to 15 degrees, where an arm would otherwise be stretched, and as the
    carriage says; the head turns a little towards hands in the air.
    """
    pivot = np.array([0.0, 0.0, _HIP_HEIGHT_H * anatomy.stature_m])
    upright = np.array([0.0, 0.0, anatomy.mid_shoulder_height_m])
    arm_m = anatomy.upper_arm_m + anatomy.forearm_m
    spine_m = norm(upright - pivot)
    lean = 0.0
    held = _held(carriage)
    for side, shoulder in enumerate(shoulders(anatomy, pivot + held @ (upright - pivot), held)):
        state = hands[side]
        wrist = state.position_m - anatomy.wrist_to_palm_m * state.rotation[:, 0]
        short = (norm(wrist - shoulder) - 0.95 * arm_m) / 0.015
        soft = short if short > 30 else math.log1p(math.exp(short))
        lean += 1.3 * 0.015 * soft / spine_m
    turn = about_y(_MAX_LEAN_RAD * math.tanh(lean / _MAX_LEAN_RAD)) @ held
    torso = Transform(pivot + turn @ (upright - pivot) + _TORSO_SHARE * sway_m, turn)
    above = np.array([_HEAD_FORWARD_M, 0.0, anatomy.neck_to_head_centre_m]) + carriage.head_m
    centre = torso.position_m + turn @ above + (1 - _TORSO_SHARE) * sway_m
    weight = yaw = pitch = 0.0
    for state in hands:
        dx, dy, dz = (state.position_m - upright - above).tolist()
        drawn = (0.05 + state.air) * (1.0 - state.with_head)
        weight += drawn
        yaw += drawn * math.atan2(dy, max(dx, 0.15))
        pitch += drawn * math.atan2(-dz, max(dx, 0.15))
    yaw *= 0.25 / (weight + 0.3)
    pitch = 0.08 + 0.15 * pitch / (weight + 0.3) + sum(state.nod_rad for state in hands)
    yaw += carriage.turn_rad + carriage.look_yaw_rad
    pitch += carriage.look_pitch_rad
    return torso, Transform(centre, about_z(yaw) @ about_y(pitch))


def _held(carriage: Carriage) -> Floats:
    """Rotation (3, 3) of a torso that does only what the carriage says."""
    if carriage is NEUTRAL:
        return np.eye(3)
    lean = about_x(-carriage.sideways_rad) @ about_y(carriage.forward_rad)
    return lean @ about_z(carriage.turn_rad)
