"""Posture: where torso and head are, given both hands."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pjpdaf.arrays import Floats
from sim.anatomy import Anatomy
from sim.motion.carriage import NEUTRAL, Carriage
from sim.motion.strokes import HandState
from sim.person.kinematics import shoulders
from sim.pose import Transform
from sim.vectors import about_x, about_y, about_z, dots, norm

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


def shoulders_over(anatomy: Anatomy, turns_rad: Floats) -> Floats:
    """Shoulder joints (n, 2, 3) of a torso that a carriage holds while the hands ask for nothing.

    turns_rad (n, 3): forward, sideways, turn. To the bit as `shoulders` of `posture`'s torso.
    """
    pivot = np.array([0.0, 0.0, _HIP_HEIGHT_H * anatomy.stature_m])
    spine = np.array([0.0, 0.0, anatomy.mid_shoulder_height_m]) - pivot
    half, drop = anatomy.shoulder_half_breadth_m, anatomy.shoulder_drop_m
    joints = [np.array([0.0, outward * half, -drop]) for outward in (-1.0, 1.0)]
    forward, sideways, turn = turns_rad.T
    held = _turns(0, -sideways) @ _turns(1, forward) @ _turns(2, turn)
    # Before the chest, within reach: a torso still leans a little for them.
    wrist = np.array([0.3, 0.0, 0.8]) - anatomy.wrist_to_palm_m * np.array([1.0, 0.0, 0.0])
    lean = np.zeros(len(turns_rad))
    for joint in joints:
        off = wrist - (pivot + held @ spine + held @ joint)
        short = (np.sqrt(dots(off, off)) - 0.95 * (anatomy.upper_arm_m + anatomy.forearm_m)) / 0.015
        soft = [s if s > 30 else math.log1p(math.exp(s)) for s in short.tolist()]
        lean += 1.3 * 0.015 * np.array(soft) / norm(spine)
    leant = [_MAX_LEAN_RAD * math.tanh(x) for x in (lean / _MAX_LEAN_RAD).tolist()]
    torso = _turns(1, np.array(leant)) @ held
    torso_m = pivot + torso @ spine
    return np.stack([torso_m + torso @ joint for joint in joints], axis=1)


def _turns(axis: int, angles_rad: Floats) -> Floats:
    """Rotations (n, 3, 3) about x, y or z, to the bit as `about_x`, `about_y`, `about_z`."""
    c, s = (np.array([of(angle) for angle in angles_rad.tolist()]) for of in (math.cos, math.sin))
    one, other = (axis + 1) % 3, (axis + 2) % 3
    turns = np.zeros((len(angles_rad), 3, 3))
    turns[:, axis, axis] = 1.0
    turns[:, one, one] = turns[:, other, other] = c
    turns[:, one, other], turns[:, other, one] = -s, s
    return turns


@dataclass(frozen=True, eq=False)
class HandsOver:
    """Planned states of a hand over F moments, as in `HandState`: positions_m (F, 3), rotations
    (F, 3, 3), curls (F, 5), air, with_head, nod_rad, swivel_rad (F,).
    """

    positions_m: Floats
    rotations: Floats
    curls: Floats
    air: Floats
    with_head: Floats
    nod_rad: Floats
    swivel_rad: Floats

    @staticmethod
    def of(rows: Floats) -> HandsOver:
        """The states of F moments from their rows (F, 16)."""
        positions, q, curls, rest = (
            np.ascontiguousarray(part) for part in np.split(rows, (3, 7, 12), axis=1)
        )
        w, x, y, z = (q / np.sqrt((q * q).sum(axis=1))[:, None]).T
        rotations = np.empty((len(q), 3, 3))
        rotations[:, 0] = np.stack(
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)], axis=1
        )
        rotations[:, 1] = np.stack(
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)], axis=1
        )
        rotations[:, 2] = np.stack(
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)], axis=1
        )
        return HandsOver(positions, rotations, curls, *rest.T)


def posture_over(
    anatomy: Anatomy,
    hands: tuple[HandsOver, HandsOver],
    sway_m: Floats,
    carriages: Sequence[Carriage],
) -> tuple[Floats, Floats, Floats, Floats]:
    """`posture` of F moments: torso_m (F, 3), torso (F, 3, 3), head_m (F, 3), head (F, 3, 3).

    sway_m (F, 3); carriages (F).
    """
    pivot = np.array([0.0, 0.0, _HIP_HEIGHT_H * anatomy.stature_m])
    upright = np.array([0.0, 0.0, anatomy.mid_shoulder_height_m])
    arm_m = anatomy.upper_arm_m + anatomy.forearm_m
    spine = upright - pivot
    held = np.array([_held(carriage) for carriage in carriages])
    carried = np.array([[c.turn_rad, c.look_yaw_rad, c.look_pitch_rad] for c in carriages])
    lean = np.zeros(len(carriages))
    half, drop = anatomy.shoulder_half_breadth_m, anatomy.shoulder_drop_m
    for state, outward in zip(hands, (-1.0, 1.0), strict=True):
        shoulder = pivot + held @ spine + held @ np.array([0.0, outward * half, -drop])
        wrist = state.positions_m - anatomy.wrist_to_palm_m * state.rotations[:, :, 0]
        short = (np.linalg.norm(wrist - shoulder, axis=1) - 0.95 * arm_m) / 0.015
        lean += 1.3 * 0.015 * np.logaddexp(0.0, short) / norm(spine)
    turn = _about_y_over(_MAX_LEAN_RAD * np.tanh(lean / _MAX_LEAN_RAD)) @ held
    torso_m = pivot + turn @ spine + _TORSO_SHARE * sway_m
    above = np.array([_HEAD_FORWARD_M, 0.0, anatomy.neck_to_head_centre_m]) + np.array(
        [carriage.head_m for carriage in carriages]
    )
    head_m = torso_m + (turn @ above[..., None])[..., 0] + (1 - _TORSO_SHARE) * sway_m
    weight, yaw, pitch = np.zeros((3, len(carriages)))
    for state in hands:
        dx, dy, dz = (state.positions_m - upright - above).T
        drawn = (0.05 + state.air) * (1.0 - state.with_head)
        weight += drawn
        yaw += drawn * np.arctan2(dy, np.maximum(dx, 0.15))
        pitch += drawn * np.arctan2(-dz, np.maximum(dx, 0.15))
    yaw = yaw * 0.25 / (weight + 0.3) + carried[:, 0] + carried[:, 1]
    pitch = 0.08 + 0.15 * pitch / (weight + 0.3) + sum(state.nod_rad for state in hands)
    c, s = np.cos(yaw), np.sin(yaw)
    zero = np.zeros_like(c)
    about_z_over = np.stack([c, -s, zero, s, c, zero, zero, zero, zero + 1], axis=1)
    head = about_z_over.reshape(-1, 3, 3) @ _about_y_over(pitch + carried[:, 2])
    return torso_m, turn, head_m, head


def _about_y_over(angle_rad: Floats) -> Floats:
    """Rotations (F, 3, 3) about y."""
    c, s = np.cos(angle_rad), np.sin(angle_rad)
    zero = np.zeros_like(c)
    turned = np.stack([c, zero, s, zero, zero + 1, zero, -s, zero, c], axis=1)
    return np.asarray(turned.reshape(-1, 3, 3))
