"""Contact projection: hands out of the table, the torso, the head and each other.

Hands are capsules, torso and head ellipsoids, the table a slab: analytic shapes a little plainer
than what is drawn. `separate` moves the palms until nothing overlaps by more than it may.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from pjpdaf.arrays import Floats, readonly
from pjpdaf.errors import BenchError
from sim.anatomy import Anatomy
from sim.hand import Finger, fingers, joint_angles
from sim.kinematics import OUTWARD, Arm, about_y, norm

ALLOWED_PENETRATION_M = 0.005
_GOOD_ENOUGH_M = 0.001  # of penetration left: the projection stops here
_ROUNDS = 24

# Bars of the palm: (across, from, to) of the average hand that `sim.hand` is drawn for [m].
_PALM_BARS = (
    (0.024, -0.062, 0.016),
    (0.008, -0.068, 0.020),
    (-0.009, -0.068, 0.016),
    (-0.024, -0.06, 0.006),
)
_PALM_RADIUS = 0.0145
_AVERAGE_BREADTH_M, _AVERAGE_PALM_M = 0.0851, 0.0774


class Unposable(BenchError):
    """A motion whose parts cannot be kept apart: the seed is rejected."""


@dataclass(frozen=True, eq=False)
class Capsules:
    """n round-ended bars: starts_m, ends_m (n, 3), radii_m (n,)."""

    starts_m: Floats
    ends_m: Floats
    radii_m: Floats

    def placed(self, position_m: Floats, rotation: Floats) -> Capsules:
        """The same bars moved by a rigid transform: position (3,), rotation (3, 3)."""
        turn = rotation.T
        return Capsules(
            self.starts_m @ turn + position_m, self.ends_m @ turn + position_m, self.radii_m
        )

    @property
    def lowest_m(self) -> float:
        """The lowest point of all bars along z [m]."""
        return float((np.minimum(self.starts_m[:, 2], self.ends_m[:, 2]) - self.radii_m).min())


@lru_cache(maxsize=64)
def _fingers(anatomy: Anatomy) -> tuple[Finger, ...]:
    return fingers(anatomy)


@lru_cache(maxsize=256)
def _hand_capsules(anatomy: Anatomy, side: int, curls: tuple[float, ...]) -> Capsules:
    starts, ends, radii = [], [], []
    broad = anatomy.hand_breadth_m / _AVERAGE_BREADTH_M
    long = anatomy.wrist_to_palm_m / _AVERAGE_PALM_M
    for across, near, far in _PALM_BARS:
        starts.append(np.array([near * long, across * broad, -0.001]))
        ends.append(np.array([far * long, across * broad, -0.001]))
        radii.append(_PALM_RADIUS * broad)
    for finger, curl in zip(_fingers(anatomy), curls, strict=True):
        joint, turn = finger.base_m, finger.rotation
        angles = joint_angles(finger, curl).tolist()
        for angle, length, r0, r1 in zip(
            angles, finger.lengths_m, finger.radii_m[:-1], finger.radii_m[1:], strict=True
        ):
            turn = turn @ about_y(angle)  # flexion: `Finger.axis` is y of the finger's frame
            tip = joint + length * turn[:, 0]
            starts.append(joint)
            ends.append(tip)
            radii.append(0.5 * (r0 + r1))
            joint = tip
    mirror = np.array([1.0, -OUTWARD[side], 1.0])  # drawn for the right hand, thumb at +y
    return Capsules(
        readonly(np.array(starts) * mirror, (None, 3), "starts"),
        readonly(np.array(ends) * mirror, (None, 3), "ends"),
        readonly(radii, (None,), "radii"),
    )


def hand_capsules(anatomy: Anatomy, side: int, curls: Floats) -> Capsules:
    """Palm (4 bars), thumb and fingers (3 each) in the hand's frame for curls (5,)."""
    return _hand_capsules(anatomy, side, tuple(round(c, 3) for c in curls.tolist()))


def height_above_table(anatomy: Anatomy, side: int, rotation: Floats, curls: Floats) -> float:
    """Height of the palm's centre above a surface [m] when the hand lies on it, turned so."""
    shape = hand_capsules(anatomy, side, curls)
    return -shape.placed(np.zeros(3), rotation).lowest_m


@dataclass(frozen=True, eq=False)
class Table:
    """The table top: a slab under top_m, from near_x_m to far_x_m, half_width_m to either side."""

    top_m: float
    near_x_m: float
    far_x_m: float
    half_width_m: float

    def penetration(self, bars: Capsules) -> float:
        """Deepest point of the bars below the top, over the table [m]; <= 0 is clear."""
        points = np.concatenate([bars.starts_m, bars.ends_m])
        radii = np.concatenate([bars.radii_m, bars.radii_m])
        over = (
            (points[:, 0] > self.near_x_m - radii)
            & (points[:, 0] < self.far_x_m + radii)
            & (np.abs(points[:, 1]) < self.half_width_m + radii)
        )
        depth = np.where(over, self.top_m - (points[:, 2] - radii), -1.0)
        return float(depth.max())


@dataclass(frozen=True, eq=False)
class Ellipsoid:
    """centre_m (3,), semi-axes_m (3,), rotation (3, 3) own -> world."""

    centre_m: Floats
    axes_m: Floats
    rotation: Floats

    def push(self, bars: Capsules) -> tuple[float, Floats]:
        """Deepest penetration of the bars [m], <= 0 is clear, and the way out (3,), a unit vector.

        First order in the gap: exact on the surface, which is where it is used.
        """
        points = np.concatenate([bars.starts_m, 0.5 * (bars.starts_m + bars.ends_m), bars.ends_m])
        radii = np.tile(bars.radii_m, 3)
        local = (points - self.centre_m) @ self.rotation
        axes = self.axes_m + radii[:, None]
        scaled = local / axes
        level = np.sqrt((scaled * scaled).sum(axis=1))
        deepest_possible = float(level.min())
        if deepest_possible > 1.5:
            return -1.0, np.array([1.0, 0.0, 0.0])
        level = np.maximum(level, 1e-6)
        slope = scaled / axes / level[:, None]
        steep = np.sqrt((slope * slope).sum(axis=1))
        depth = (1.0 - level) / steep
        worst = int(depth.argmax())
        out: Floats = self.rotation @ (slope[worst] / steep[worst])
        return float(depth[worst]), out


def head_ellipsoid(anatomy: Anatomy, position_m: Floats, rotation: Floats) -> Ellipsoid:
    """The head, `sim.pose`'s frame: x out of the face, z to the crown."""
    axes = 0.5 * np.array([anatomy.head_depth_m, anatomy.head_breadth_m, anatomy.head_height_m])
    return Ellipsoid(position_m, axes, rotation)


def torso_ellipsoids(
    anatomy: Anatomy, position_m: Floats, rotation: Floats
) -> tuple[Ellipsoid, ...]:
    """Chest and belly, in shares of the stature, below the mid-shoulder point."""
    H = anatomy.stature_m
    chest = np.array([0.005, 0.0, -0.105]) * H
    belly = np.array([0.010, 0.0, -0.225]) * H
    return (
        Ellipsoid(position_m + rotation @ chest, np.array([0.064, 0.095, 0.115]) * H, rotation),
        Ellipsoid(position_m + rotation @ belly, np.array([0.066, 0.085, 0.110]) * H, rotation),
    )


def _overlaps(a: Capsules, b: Capsules) -> tuple[Floats, Floats, Floats]:
    """Overlap (n, m) of each bar of a with each of b, their axes' distance, and b -> a (n, m, 3).

    All pairs at once; closest points of segments: Ericson, Real-Time Collision Detection 5.1.9.
    """
    p, d1 = a.starts_m[:, None], (a.ends_m - a.starts_m)[:, None]
    q, d2 = b.starts_m[None], (b.ends_m - b.starts_m)[None]
    r = p - q
    A, E = (d1 * d1).sum(-1), (d2 * d2).sum(-1)
    F, C, B = (d2 * r).sum(-1), (d1 * r).sum(-1), (d1 * d2).sum(-1)
    denominator = np.maximum(A * E - B * B, 1e-12)
    s = np.clip((B * F - C * E) / denominator, 0.0, 1.0)
    t = np.clip((B * s + F) / E, 0.0, 1.0)
    s = np.clip((B * t - C) / A, 0.0, 1.0)
    between = r + s[..., None] * d1 - t[..., None] * d2
    distance = np.sqrt((between * between).sum(-1))
    return a.radii_m[:, None] + b.radii_m[None] - distance, distance, between


def capsule_gap(a: Capsules, b: Capsules) -> tuple[float, Floats]:
    """Deepest overlap of any bar of a with any of b [m], <= 0 is clear, and b -> a (3,), unit."""
    overlap, distance, between = _overlaps(a, b)
    i, j = np.unravel_index(int(overlap.argmax()), overlap.shape)
    gap = float(distance[i, j])
    way: Floats = between[i, j] / gap if gap > 1e-9 else np.array([1.0, 0.0, 0.0])
    return float(overlap[i, j]), way


def _way_apart(a: Capsules, b: Capsules, steady: Floats, trust: float) -> tuple[float, Floats]:
    """Deepest overlap [m] and a way out for a (3,), unit.

    The mean of all overlapping pairs' ways, each as heavy as it is deep, so that it changes
    smoothly with the pose; `steady` (3,), a unit vector, gets the weight `trust` of 0..1 beside
    it, because fingers between fingers push both ways.
    """
    overlap, distance, between = _overlaps(a, b)
    deepest = float(overlap.max())
    if deepest <= 0.0:
        return deepest, steady
    weight = np.where(overlap > 0.0, overlap / np.maximum(distance, 1e-6), 0.0)
    mean = (weight[..., None] * between).sum(axis=(0, 1)) / np.maximum(overlap, 0.0).sum()
    way = (1.0 - trust) * mean + trust * steady
    length = norm(way)
    return deepest, way / length if length > 1e-6 else steady


@dataclass(frozen=True, eq=False)
class Obstacles:
    """What the hands must keep out of, besides each other."""

    table: Table
    solids: tuple[Ellipsoid, ...]


@dataclass(frozen=True)
class Penetration:
    """Deepest overlap of either hand with each thing [m]; <= 0 is clear."""

    table_m: float
    solids_m: float
    hands_m: float

    @property
    def worst_m(self) -> float:
        """The deepest of all."""
        return max(self.table_m, self.solids_m, self.hands_m)


def _near(arms: tuple[Arm, Arm], reach_m: float) -> bool:
    offset = arms[0].palm_m - arms[1].palm_m
    return float(offset @ offset) < reach_m * reach_m


def penetration(
    anatomy: Anatomy, arms: tuple[Arm, Arm], curls: Floats, obstacles: Obstacles
) -> Penetration:
    """How deep the hands (curls (2, 5)) of these arms are in things, and in each other."""
    bars = tuple(
        hand_capsules(anatomy, side, curls[side]).placed(arms[side].palm_m, arms[side].hand)
        for side in (0, 1)
    )
    solids = max((solid.push(b)[0] for solid in obstacles.solids for b in bars), default=-1.0)
    return Penetration(
        table_m=max(obstacles.table.penetration(b) for b in bars),
        solids_m=solids,
        hands_m=capsule_gap(bars[0], bars[1])[0],
    )


def separate(
    anatomy: Anatomy,
    palms_m: tuple[Floats, Floats],
    solve: Callable[[int, Floats], Arm],
    curls: Floats,
    obstacles: Obstacles,
) -> tuple[Arm, Arm]:
    """Arms whose palms are as near to palms_m (2 x (3,)) as contact allows.

    solve(side, palm) gives an arm. Each round moves each palm out of its deepest overlaps; hands
    share theirs. Raises Unposable when more than 5 mm of overlap are left at the end.
    """
    shapes = tuple(hand_capsules(anatomy, side, curls[side]) for side in (0, 1))
    targets = [palms_m[0], palms_m[1]]
    arms = (solve(0, targets[0]), solve(1, targets[1]))
    for number in range(_ROUNDS):
        bars = tuple(shapes[s].placed(arms[s].palm_m, arms[s].hand) for s in (0, 1))
        moved = [False, False]
        for side in (0, 1):
            sunk = obstacles.table.penetration(bars[side])
            shift = np.zeros(3)
            if sunk > _GOOD_ENOUGH_M:
                shift[2] += sunk
                moved[side] = True
            for solid in obstacles.solids:
                depth, out = solid.push(bars[side])
                if depth > _GOOD_ENOUGH_M:
                    shift = shift + depth * out
                    moved[side] = True
            if moved[side]:
                targets[side] = arms[side].palm_m + shift
        if _near(arms, 0.75):
            # Without a centre line to part along, each hand goes to its own side.
            apart = arms[0].palm_m - arms[1].palm_m + np.array([0.0, 0.01 * OUTWARD[0], 0.0])
            depth, way = _way_apart(
                bars[0],
                bars[1],
                apart / max(norm(apart), 1e-9),
                min(0.25 + 0.08 * number, 1.0),
            )
            if depth > _GOOD_ENOUGH_M:
                for side, sign in ((0, 0.55), (1, -0.55)):
                    start = targets[side] if moved[side] else arms[side].palm_m
                    targets[side] = start + (sign * depth) * way
                    moved[side] = True
        if not any(moved):
            return arms
        arms = (
            solve(0, targets[0]) if moved[0] else arms[0],
            solve(1, targets[1]) if moved[1] else arms[1],
        )
    left = penetration(anatomy, arms, curls, obstacles)
    if left.worst_m > ALLOWED_PENETRATION_M:
        raise Unposable(
            f"hands overlap by {1000 * left.worst_m:.1f} mm after contact projection "
            f"(allowed {1000 * ALLOWED_PENETRATION_M:.0f} mm): use another seed, or move the "
            f"paths apart"
        )
    return arms
