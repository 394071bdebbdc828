"""Contact: hands and arms as round-ended bars, and how deep they are in things and each other.

Hands, forearms and upper arms are capsules with the radii of the drawn skin and sleeves. Natural
neighbours do not count: the parts of one arm, upper arms against the torso and each other, and the
elbow's end of a forearm against the torso.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Floats, readonly
from pjpdaf.errors import BenchError
from sim.anatomy import Anatomy
from sim.contact.solids import Obstacles, Slab
from sim.person.body import ELBOW_M, WRIST_M
from sim.person.hand import fingers, joint_angles
from sim.person.kinematics import OUTWARD, Arm
from sim.pose import SIDES

ALLOWED_PENETRATION_M = 0.005

# Bars of the palm: (across, from, to) of the average hand that `sim.person.hand` is drawn for [m].
_PALM_BARS = (
    (0.024, -0.062, 0.016),
    (0.008, -0.068, 0.020),
    (-0.009, -0.068, 0.016),
    (-0.024, -0.06, 0.006),
)
_PALM_RADIUS = 0.0145
_AVERAGE_BREADTH_M, _AVERAGE_PALM_M, _AVERAGE_STATURE_M = 0.0851, 0.0774, 1.72

# Sleeves, as drawn for the average person: radii from the elbow to 3/4 of the way [m].
_SLEEVE_M = (ELBOW_M, 0.0455, 0.0415, 0.036)
_CUFF_M = 0.012  # the sleeve ends this much before the wrist, flat
_UPPER_M = (0.0495, 0.0455)  # upper and lower half of the upper arm
_FOREARM_POINTS = np.linspace(0.0, 1.0, 9)  # shares of the sleeve from the elbow
_BESIDE_TORSO = 0.3  # share of the forearm, from the elbow, that may rest against the torso
_UPPER_BARS = np.array([[0.12, 0.55], [0.55, 1.0]])  # shares of the upper arm
_UPPER_POINTS = np.array([0.5, 0.75])  # of the upper arm: what may meet the head

# The same for every arm: how its bars and points follow each other.
PARTS = ("hand", "forearm", "upper arm")
HAND, FOREARM, UPPER_ARM = 0, 1, 2
_HAND_BARS, _HAND_POINTS = 19, 47
PART_OF_BAR = np.repeat([HAND, FOREARM, UPPER_ARM], [_HAND_BARS, 4, 2])
PART_OF_POINT = np.repeat([HAND, FOREARM, UPPER_ARM], [_HAND_POINTS, 9, 2])
SHARE_OF_POINT = np.concatenate([np.ones(_HAND_POINTS), _FOREARM_POINTS, _UPPER_POINTS])
SHARE_OF_BAR = np.array([1.0] * _HAND_BARS + [0.125, 0.375, 0.625, 0.86, 0.335, 0.775])
_FIRST_BARS, _FIRST_POINTS = (0, 19, 23), (0, 47, 56)  # where each part begins
_CLEAR_M = -1.0  # said of what does not count

Flags = NDArray[np.bool_]


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


@dataclass(frozen=True, eq=False)
class _Digits:
    """A right hand's thumb and fingers, 5 of 3 segments, ready to be bent.

    bases_m (5, 3): first joints; ahead, up (5, 3): x and z of the straight fingers; lengths_m,
    radii_m (5, 3); straight_rad, more_rad (5, 3): how far a segment is turned about y from the
    finger's frame at curl 0, and how much further at 1.
    """

    bases_m: Floats
    ahead: Floats
    up: Floats
    lengths_m: Floats
    radii_m: Floats
    straight_rad: Floats
    more_rad: Floats

    def joints(self, curls: Floats) -> Floats:
        """First joint, two more, tip of each finger (5, 4, 3) [m] for curls (5,)."""
        turned = (self.straight_rad + curls[:, None] * self.more_rad)[..., None]
        along = np.cos(turned) * self.ahead[:, None] - np.sin(turned) * self.up[:, None]
        bones = np.concatenate([self.bases_m[:, None], self.lengths_m[..., None] * along], axis=1)
        return np.cumsum(bones, axis=1)


@lru_cache(maxsize=64)
def _digits(anatomy: Anatomy) -> _Digits:
    drawn = fingers(anatomy)
    radii = np.array([finger.radii_m for finger in drawn])
    straight = np.array([joint_angles(finger, 0.0) for finger in drawn])
    fist = np.array([joint_angles(finger, 1.0) for finger in drawn])
    return _Digits(
        bases_m=np.array([finger.base_m for finger in drawn]),
        ahead=np.array([finger.rotation[:, 0] for finger in drawn]),
        up=np.array([finger.rotation[:, 2] for finger in drawn]),
        lengths_m=np.array([finger.lengths_m for finger in drawn]),
        radii_m=0.5 * (radii[:, :-1] + radii[:, 1:]),
        straight_rad=np.cumsum(straight, axis=1),
        more_rad=np.cumsum(fist - straight, axis=1),
    )


@lru_cache(maxsize=256)
def _hand_capsules(anatomy: Anatomy, side: int, curls: tuple[float, ...]) -> Capsules:
    broad = anatomy.hand_breadth_m / _AVERAGE_BREADTH_M
    long = anatomy.wrist_to_palm_m / _AVERAGE_PALM_M
    across, near, far = np.array(_PALM_BARS).T
    lies = np.full(len(across), -0.001)
    digits = _digits(anatomy)
    joints = digits.joints(np.array(curls))
    mirror = np.array([1.0, -OUTWARD[side], 1.0])  # drawn for the right hand, thumb at +y
    starts, ends = (
        mirror
        * np.concatenate(
            [np.column_stack([reach * long, across * broad, lies]), chain.reshape(-1, 3)]
        )
        for reach, chain in ((near, joints[:, :-1]), (far, joints[:, 1:]))
    )
    return Capsules(
        readonly(starts, (None, 3), "starts"),
        readonly(ends, (None, 3), "ends"),
        readonly(
            np.concatenate([np.full(len(across), _PALM_RADIUS * broad), digits.radii_m.ravel()]),
            (None,),
            "radii",
        ),
    )


def hand_capsules(anatomy: Anatomy, side: int, curls: Floats) -> Capsules:
    """Palm (4 bars), thumb and fingers (3 each) in the hand's frame for curls (5,)."""
    return _hand_capsules(anatomy, side, tuple(curls.tolist()))


def height_above_table(anatomy: Anatomy, side: int, rotation: Floats, curls: Floats) -> float:
    """Height of the palm's centre above a surface [m] when the hand lies on it, turned so."""
    shape = hand_capsules(anatomy, side, curls)
    return -shape.placed(np.zeros(3), rotation).lowest_m


def overlaps(a: Capsules, b: Capsules) -> tuple[Floats, Floats, Floats]:
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
    overlap, distance, between = overlaps(a, b)
    i, j = np.unravel_index(int(overlap.argmax()), overlap.shape)
    gap = float(distance[i, j])
    way: Floats = between[i, j] / gap if gap > 1e-9 else np.array([1.0, 0.0, 0.0])
    return float(overlap[i, j]), way


@dataclass(frozen=True, eq=False)
class Shape:
    """What an arm consists of, apart from its pose: 25 bars to meet the other arm, 58 points to
    meet solids; hand, forearm, upper arm in this order.

    hand: its bars in the hand's frame; hand_points_m (47, 3) likewise. sleeve (4, 2): shares of the
    forearm where its bars begin and end; on_forearm (9, 1): of its points. radii_m (25,),
    point_radii_m (58,). reach_m: of the hand, from the palm's centre.
    """

    hand: Capsules
    hand_points_m: Floats
    sleeve: Floats
    on_forearm: Floats
    radii_m: Floats
    point_radii_m: Floats
    reach_m: float

    def bars(self, arm: Arm) -> Capsules:
        """The bars of an arm in this pose, world."""
        turn = arm.hand.T
        fore, upper = arm.wrist_m - arm.elbow_m, arm.elbow_m - arm.shoulder_m
        first, last = (
            np.concatenate(
                [
                    hand @ turn + arm.palm_m,
                    arm.elbow_m + self.sleeve[:, end, None] * fore,
                    arm.shoulder_m + _UPPER_BARS[:, end, None] * upper,
                ]
            )
            for end, hand in enumerate((self.hand.starts_m, self.hand.ends_m))
        )
        return Capsules(first, last, self.radii_m)

    def points(self, arm: Arm) -> Floats:
        """The points (58, 3) of an arm in this pose, world."""
        return np.concatenate(
            [
                self.hand_points_m @ arm.hand.T + arm.palm_m,
                arm.elbow_m + self.on_forearm * (arm.wrist_m - arm.elbow_m),
                arm.shoulder_m + _UPPER_POINTS[:, None] * (arm.elbow_m - arm.shoulder_m),
            ]
        )


POINTS_OF_PART = (slice(0, 47), slice(47, 56), slice(56, 58))  # of hand, forearm, upper arm


@lru_cache(maxsize=512)
def _arm_shape(anatomy: Anatomy, side: int, curls: tuple[float, ...]) -> Shape:
    hand = _hand_capsules(anatomy, side, curls)
    k = anatomy.stature_m / _AVERAGE_STATURE_M
    wrist = WRIST_M * anatomy.hand_breadth_m / _AVERAGE_BREADTH_M
    radii = np.array([*(r * k for r in _SLEEVE_M), wrist])
    # The round end of the last bar stands for the cuff's flat one.
    end = 1.0 - (_CUFF_M + 0.55 * wrist) / anatomy.forearm_m
    ends = np.array([0.0, 0.25, 0.5, 0.75, end])
    along = _FOREARM_POINTS * end
    # Fingers are chains: a bar that goes on from another starts where that one ends.
    first = np.ones(_HAND_BARS, dtype=bool)
    first[len(_PALM_BARS) :] = np.tile([True, False, False], 5)
    middles = 0.5 * (hand.starts_m + hand.ends_m)
    upper = np.array(_UPPER_M) * k
    r = hand.radii_m
    return Shape(
        hand=hand,
        hand_points_m=np.concatenate([hand.ends_m, middles, hand.starts_m[first]]),
        sleeve=np.column_stack([ends[:-1], ends[1:]]),
        on_forearm=along[:, None],
        radii_m=np.concatenate([r, 0.5 * (radii[:-1] + radii[1:]), upper]),
        point_radii_m=np.concatenate(
            [r, r, r[first], np.interp(along, np.linspace(0.0, 1.0, 5), radii), upper]
        ),
        reach_m=float(np.sqrt((hand.ends_m**2).sum(axis=1)).max() + r.max()),
    )


def arm_shape(anatomy: Anatomy, side: int, curls: Floats) -> Shape:
    """The shape of an arm whose fingers are curled so (5,)."""
    return _arm_shape(anatomy, side, tuple(curls.tolist()))


@lru_cache(maxsize=8)
def exempt(names: tuple[str, ...]) -> Flags:
    """Which points (k, 58) do not count against solids of these names (k)."""
    free = np.zeros((len(names), len(PART_OF_POINT)), dtype=bool)
    for row, name in enumerate(names):
        if name != "head":
            free[row] |= PART_OF_POINT == UPPER_ARM
        if name == "torso":
            free[row] |= (PART_OF_POINT == FOREARM) & (SHARE_OF_POINT < _BESIDE_TORSO)
    free.flags.writeable = False
    return free


def solid_depths(
    shape: Shape, points_m: Floats, obstacles: Obstacles, table: Slab
) -> tuple[Floats, Floats]:
    """Depths (k + 1, 58) [m] of an arm's points in the k solids and in the table, the last row, and
    the ways out (k + 1, 58, 3). What does not count is clear.
    """
    depth, out = obstacles.solids.push(points_m, shape.point_radii_m)
    depth[exempt(obstacles.solids.names)] = _CLEAR_M
    on_table, off = table.push(points_m, shape.point_radii_m)
    on_table[PART_OF_POINT == UPPER_ARM] = _CLEAR_M
    return np.concatenate([depth, on_table[None]]), np.concatenate([out, off[None]])


@dataclass(frozen=True, eq=False)
class Penetration:
    """Deepest overlap [m] of each pair of parts, by their names; <= 0 is clear."""

    pairs: Mapping[tuple[str, str], float]

    @property
    def worst(self) -> tuple[str, str]:
        """The pair that overlaps most."""
        return max(self.pairs, key=self.pairs.__getitem__)

    @property
    def worst_m(self) -> float:
        """The deepest of all."""
        return self.pairs[self.worst]

    @property
    def hands_m(self) -> float:
        """Of one hand in the other."""
        return self.pairs[part_name(0, HAND), part_name(1, HAND)]


def part_name(side: int, part: int) -> str:
    """Such as "right forearm"."""
    return f"{SIDES[side]} {PARTS[part]}"


def penetration(
    anatomy: Anatomy, arms: tuple[Arm, Arm], curls: Floats, obstacles: Obstacles
) -> Penetration:
    """How deep these arms (curls (2, 5)) are in things, and in each other."""
    shapes = tuple(arm_shape(anatomy, side, curls[side]) for side in (0, 1))
    overlap, _, _ = overlaps(shapes[0].bars(arms[0]), shapes[1].bars(arms[1]))
    by_part = np.maximum.reduceat(
        np.maximum.reduceat(overlap, _FIRST_BARS, axis=0), _FIRST_BARS, axis=1
    )
    pairs = {
        (part_name(0, a), part_name(1, b)): float(by_part[a, b])
        for a in range(3)
        for b in range(3)
        if a != UPPER_ARM or b != UPPER_ARM
    }
    for side in (0, 1):
        points = shapes[side].points(arms[side])
        depth, _ = solid_depths(shapes[side], points, obstacles, obstacles.table.slab())
        deepest = np.maximum.reduceat(depth, _FIRST_POINTS, axis=1)
        for row, name in enumerate((*obstacles.solids.names, "table")):
            for part in range(3):
                key = (part_name(side, part), name)
                if deepest[row, part] > _CLEAR_M:
                    pairs[key] = max(pairs.get(key, _CLEAR_M), float(deepest[row, part]))
    return Penetration(pairs)
