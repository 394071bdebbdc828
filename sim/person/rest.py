"""A person at rest: upright, both palms on the table. For tests, examples and backgrounds."""

from __future__ import annotations

import numpy as np

from pjpdaf.arrays import Floats
from sim.anatomy import Anatomy
from sim.pose import Pose, Transform
from sim.specs import RoomSpec


def rest_pose(
    anatomy: Anatomy,
    room: RoomSpec | None = None,
    palms_m: tuple[tuple[float, float, float], tuple[float, float, float]] | None = None,
    time_s: float = 0.0,
    curl: float = 0.06,
) -> Pose:
    """Sit upright, palms (right, left) [m, world] at `palms_m` or flat on the table."""
    room = room or RoomSpec()
    z = room.table_height_m + 0.030
    palms = palms_m or ((0.34, -0.20, z), (0.34, 0.20, z))
    shoulder_z = anatomy.mid_shoulder_height_m
    uppers, fores, hands = [], [], []
    for side, palm in zip((-1.0, 1.0), palms, strict=True):
        shoulder = np.array(
            [0.0, side * anatomy.shoulder_half_breadth_m, shoulder_z - anatomy.shoulder_drop_m]
        )
        # The hand points forward and inwards, and lies flat.
        along = _unit(np.array([0.85, -side * 0.40, 0.0]))
        hand = _frame(along, np.array([0.0, 0.0, 1.0]))
        wrist = np.array(palm) - anatomy.wrist_to_palm_m * along
        elbow = _elbow(shoulder, wrist, anatomy, np.array([-0.25, side * 0.65, -0.7]))
        uppers.append(Transform(shoulder, _frame(_unit(elbow - shoulder), np.array([1.0, 0, 0.3]))))
        fores.append(Transform(elbow, _frame(_unit(wrist - elbow), np.array([0.0, 0.0, 1.0]))))
        hands.append(Transform(np.array(palm), hand))
    head_z = shoulder_z + anatomy.neck_to_head_centre_m
    return Pose(
        time_s=time_s,
        torso=Transform(np.array([0.0, 0.0, shoulder_z]), np.eye(3)),
        head=Transform(np.array([0.02, 0.0, head_z]), np.eye(3)),
        upper_arms=(uppers[0], uppers[1]),
        forearms=(fores[0], fores[1]),
        hands=(hands[0], hands[1]),
        curls=np.full((2, 5), curl),
    )


def _unit(vector: Floats) -> Floats:
    return np.asarray(vector / np.linalg.norm(vector))


def _frame(along: Floats, up: Floats) -> Floats:
    """Rotation with x along a unit vector and z near `up`."""
    y = _unit(np.cross(up, along))
    return np.column_stack([along, y, np.cross(along, y)])


def _elbow(shoulder: Floats, wrist: Floats, anatomy: Anatomy, towards: Floats) -> Floats:
    reach = wrist - shoulder
    distance = float(np.linalg.norm(reach))
    upper, fore = anatomy.upper_arm_m, anatomy.forearm_m
    along = reach / distance
    a = (distance**2 + upper**2 - fore**2) / (2 * distance)
    out = _unit(towards - (towards @ along) * along)
    return np.asarray(shoulder + a * along + np.sqrt(max(upper**2 - a**2, 0.0)) * out)
