"""Moments at which arms may touch something, found for F moments at once.

Most moments of most motions have no contact: there the arms are where the plan has them. All
others are left to `sim.contact.separation`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pjpdaf.arrays import Bools, Floats
from sim.anatomy import Anatomy
from sim.contact.arm_shape import (
    BOTH_UPPER,
    PART_OF_POINT,
    UPPER_ARM,
    arm_shape,
    digits_of,
    palm_bars,
)
from sim.contact.capsules import Capsules, overlaps
from sim.contact.contact import exempt
from sim.contact.solids import Table, Trunk, person_solids, trunk
from sim.person.kinematics import OUTWARD
from sim.silhouettes.arms_over import ArmsOver
from sim.vectors import dots

_LEAST_M = 0.0005  # overlaps up to this push nothing (`sim.contact.separation`)
_COUNTS = PART_OF_POINT != UPPER_ARM
_UPPER_BARS = np.array([[0.12, 0.55], [0.55, 1.0]])
_UPPER_POINTS = np.array([0.5, 0.75])


@dataclass(frozen=True, eq=False)
class ArmShapes:
    """Bars (F, 25) and points (F, 58, 3) of an arm over F moments; point_radii_m (58,)."""

    bars: Capsules
    points_m: Floats
    point_radii_m: Floats


def shapes_over(anatomy: Anatomy, side: int, arm: ArmsOver, curls: Floats) -> ArmShapes:
    """`sim.contact.arm_shape.arm_shape` of an arm with curls (F, 5)."""
    fixed = arm_shape(anatomy, side, curls[0])  # all but the fingers' places
    joints = digits_of(anatomy).joints_over(curls)
    frames = len(joints)
    palm = palm_bars(anatomy)
    mirror = np.array([1.0, -OUTWARD[side], 1.0])
    turn = arm.hand.swapaxes(1, 2)
    fore, upper = arm.wrist_m - arm.elbow_m, arm.elbow_m - arm.shoulder_m
    ends = []
    for end, (of_palm, chain) in enumerate(
        ((palm.starts_m, joints[:, :, :-1]), (palm.ends_m, joints[:, :, 1:]))
    ):
        still = np.broadcast_to(of_palm, (frames, *of_palm.shape))
        hand = mirror * np.concatenate([still, chain.reshape(frames, -1, 3)], axis=1)
        ends.append(
            np.concatenate(
                [
                    hand @ turn + arm.palm_m[:, None],
                    arm.elbow_m[:, None] + fixed.sleeve[:, end, None] * fore[:, None],
                    arm.shoulder_m[:, None] + _UPPER_BARS[:, end, None] * upper[:, None],
                ],
                axis=1,
            )
        )
    starts, stops = ends
    hand_bars = len(fixed.hand.radii_m)
    first = np.ones(hand_bars, dtype=bool)
    first[len(palm.radii_m) :] = np.tile([True, False, False], 5)
    points = np.concatenate(
        [
            stops[:, :hand_bars],
            0.5 * (starts + stops)[:, :hand_bars],
            starts[:, :hand_bars][:, first],
            arm.elbow_m[:, None] + fixed.on_forearm * fore[:, None],
            arm.shoulder_m[:, None] + _UPPER_POINTS[:, None] * upper[:, None],
        ],
        axis=1,
    )
    return ArmShapes(Capsules(starts, stops, fixed.radii_m), points, fixed.point_radii_m)


def may_touch(
    anatomy: Anatomy,
    shapes: tuple[ArmShapes, ArmShapes],
    table: Table,
    torso: tuple[Floats, Floats],
    head: tuple[Floats, Floats],
) -> Bools:
    """Moments (F,) at which an arm may be in the other, in the body or in the table.

    torso, head: positions (F, 3) and rotations (F, 3, 3). True more often than need be, never less.
    """
    touch = _pair(shapes)
    for arm in shapes:
        points, radii = arm.points_m, arm.point_radii_m
        low = (points[:, _COUNTS, 2] - radii[_COUNTS]).min(axis=1)
        touch |= low < table.top_m - _LEAST_M
        touch |= _in_body(anatomy, points, radii, torso, head)
    return touch


def _pair(shapes: tuple[ArmShapes, ArmShapes]) -> Bools:
    right, left = (shape.bars for shape in shapes)
    boxes = []
    for bars in (right, left):
        r = bars.radii_m[:, None]
        boxes.append(
            (
                (np.minimum(bars.starts_m, bars.ends_m) - r).min(axis=1),
                (np.maximum(bars.starts_m, bars.ends_m) + r).max(axis=1),
            )
        )
    (low, high), (other_low, other_high) = boxes
    near = ((low < other_high) & (high > other_low)).all(axis=1)
    touch = np.zeros(len(near), dtype=bool)
    rows = np.flatnonzero(near)
    if len(rows):
        a, b = (Capsules(s.starts_m[rows], s.ends_m[rows], s.radii_m) for s in (right, left))
        overlap, _, _ = overlaps(a, b)
        overlap[:, BOTH_UPPER] = 0.0
        touch[rows] = overlap.max(axis=(1, 2)) > _LEAST_M
    return touch


def _in_body(
    anatomy: Anatomy,
    points: Floats,
    radii: Floats,
    torso: tuple[Floats, Floats],
    head: tuple[Floats, Floats],
) -> Bools:
    solids = person_solids(anatomy, np.zeros(3), np.eye(3), np.zeros(3), np.eye(3))
    free = exempt(solids.names)
    touch = np.zeros(len(points), dtype=bool)
    away = points - head[0][:, None]
    if _within(away, np.zeros(3), solids.head_axes_m.max() + radii.max()).any():
        in_head = away @ head[1] / (solids.head_axes_m + radii[:, None])
        touch |= (dots(in_head, in_head) < 1.0).any(axis=1)
    local = (points - torso[0][:, None]) @ torso[1]
    touch |= _in_trunk(trunk(anatomy), local, radii, ~free[1])
    # Shoulders and neck go with the torso; the thighs stand still.
    for bar, (start, end, radius) in enumerate(
        zip(solids.starts_m, solids.ends_m, solids.radii_m, strict=True), start=2
    ):
        at = points if "thigh" in solids.names[bar] else local
        along = end - start
        about = 0.5 * np.abs(along) + radius + radii.max()
        row, point = np.nonzero(_within(at, 0.5 * (start + end), about) & ~free[bar])
        offset = at[row, point] - start
        share = np.clip(offset @ along / (along @ along), 0.0, 1.0)
        beside = offset - share[:, None] * along
        reach = radius + radii[point] - _LEAST_M
        touch[row[dots(beside, beside) < reach * reach]] = True
    return touch


def _within(points: Floats, middle: Floats, half: Floats) -> Bools:
    """Which points (..., 3) are in a box: its middle (3,), half its size (3,) or of all three."""
    sizes = np.broadcast_to(half, 3)
    x, y, z = (np.abs(points[..., k] - middle[k]) < sizes[k] for k in range(3))
    return np.asarray(x & y & z)


def _in_trunk(body: Trunk, points: Floats, radii: Floats, counts: Bools) -> Bools:
    """Whether any of the round points (F, n, 3) that count (n,) is in the trunk, its frame."""
    row, point = np.nonzero(_within(points, np.zeros(3), _TRUNK_WITHIN_M) & counts)
    touch = np.zeros(len(points), dtype=bool)
    depth, _ = body.push(points[row, point], radii[point])
    touch[row[depth > _LEAST_M]] = True
    return touch


_TRUNK_WITHIN_M = np.array([0.25, 0.35, 0.75])  # everything in the trunk, with an arm's thickness
