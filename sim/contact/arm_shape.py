"""The shape of an arm: the bars of its hand, its sleeve and its upper arm, apart from any pose."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from pjpdaf.arrays import Floats, readonly
from sim.anatomy import Anatomy
from sim.contact.capsules import Capsules
from sim.person.hand import fingers, joint_angles
from sim.person.kinematics import OUTWARD, Arm
from sim.person.sleeves import FORE_SLEEVE_M, WRIST_M

# Bars of the palm: (across, from, to) of the average hand that `sim.person.hand` is drawn for [m].
_PALM_BARS = (
    (0.024, -0.062, 0.016),
    (0.008, -0.068, 0.020),
    (-0.009, -0.068, 0.016),
    (-0.024, -0.06, 0.006),
)
_PALM_RADIUS = 0.0145
_AVERAGE_BREADTH_M, _AVERAGE_PALM_M, _AVERAGE_STATURE_M = 0.0851, 0.0774, 1.72

_CUFF_M = 0.012  # the sleeve ends this much before the wrist, flat
_UPPER_M = (0.0495, 0.0455)  # upper and lower half of the upper arm
_FOREARM_POINTS = np.linspace(0.0, 1.0, 9)  # shares of the sleeve from the elbow
_UPPER_BARS = np.array([[0.12, 0.55], [0.55, 1.0]])  # shares of the upper arm
_UPPER_POINTS = np.array([0.5, 0.75])  # shares of the upper arm, points that may meet the head

# The same for every arm: how its bars and points follow each other.
PARTS = ("hand", "forearm", "upper arm")
HAND, FOREARM, UPPER_ARM = 0, 1, 2
_HAND_BARS, _HAND_POINTS = 19, 47
PART_OF_BAR = np.repeat([HAND, FOREARM, UPPER_ARM], [_HAND_BARS, 4, 2])
# Pairs of bars of two arms: upper arms do not push each other.
BOTH_UPPER = (PART_OF_BAR[:, None] == UPPER_ARM) & (PART_OF_BAR[None] == UPPER_ARM)
PART_OF_POINT = np.repeat([HAND, FOREARM, UPPER_ARM], [_HAND_POINTS, 9, 2])
SHARE_OF_POINT = np.concatenate([np.ones(_HAND_POINTS), _FOREARM_POINTS, _UPPER_POINTS])
SHARE_OF_BAR = np.array([1.0] * _HAND_BARS + [0.125, 0.375, 0.625, 0.86, 0.335, 0.775])


@dataclass(frozen=True, eq=False)
class Digits:
    """A right hand's thumb and fingers, 5 of 3 segments, ready to be bent.

    bases_m (5, 3): first joints; ahead, up (5, 3): x and z of the straight fingers; lengths_m,
    radii_m (5, 3), joint_radii_m (5, 4); straight_rad, more_rad (5, 3): how far a segment is turned
    about y from the finger's frame at curl 0, and how much further at 1.
    """

    bases_m: Floats
    ahead: Floats
    up: Floats
    lengths_m: Floats
    radii_m: Floats
    joint_radii_m: Floats
    straight_rad: Floats
    more_rad: Floats

    def joints(self, curls: Floats) -> Floats:
        """First joint, two more, tip of each finger (..., 5, 4, 3) [m] for curls (..., 5)."""
        turned = (self.straight_rad + curls[..., None] * self.more_rad)[..., None]
        along = np.cos(turned) * self.ahead[:, None] - np.sin(turned) * self.up[:, None]
        bases = np.broadcast_to(self.bases_m[:, None], (*along.shape[:-2], 1, 3))
        bones = np.concatenate([bases, self.lengths_m[..., None] * along], axis=-2)
        return np.cumsum(bones, axis=-2)

    def joints_over(self, curls: Floats) -> Floats:
        """The joints (F, 5, 4, 3) [m] for the curls (F, 5) of F moments."""
        turned = (self.straight_rad + curls[..., None] * self.more_rad)[..., None]
        along = np.cos(turned) * self.ahead[:, None] - np.sin(turned) * self.up[:, None]
        reach = np.cumsum(self.lengths_m[..., None] * along, axis=-2)
        bases = np.broadcast_to(self.bases_m[:, None], (*reach.shape[:-2], 1, 3))
        return np.concatenate([bases, bases + reach], axis=-2)


@lru_cache(maxsize=64)
def digits_of(anatomy: Anatomy) -> Digits:
    """The digits of a right hand."""
    drawn = fingers(anatomy)
    radii = np.array([finger.radii_m for finger in drawn])
    straight = np.array([joint_angles(finger, 0.0) for finger in drawn])
    fist = np.array([joint_angles(finger, 1.0) for finger in drawn])
    return Digits(
        bases_m=np.array([finger.base_m for finger in drawn]),
        ahead=np.array([finger.rotation[:, 0] for finger in drawn]),
        up=np.array([finger.rotation[:, 2] for finger in drawn]),
        lengths_m=np.array([finger.lengths_m for finger in drawn]),
        radii_m=0.5 * (radii[:, :-1] + radii[:, 1:]),
        joint_radii_m=radii,
        straight_rad=np.cumsum(straight, axis=1),
        more_rad=np.cumsum(fist - straight, axis=1),
    )


@lru_cache(maxsize=256)
def _hand_capsules(anatomy: Anatomy, side: int, curls: tuple[float, ...]) -> Capsules:
    one = hand_capsules_over(anatomy, side, np.array([curls]))
    return Capsules(
        readonly(one.starts_m[0], (None, 3), "starts"),
        readonly(one.ends_m[0], (None, 3), "ends"),
        readonly(one.radii_m, (None,), "radii"),
    )


def hand_capsules_over(anatomy: Anatomy, side: int, curls: Floats) -> Capsules:
    """The bars (n, 19) of `hand_capsules` for curls (n, 5), to the bit; their radii (19,)."""
    palm, digits = palm_bars(anatomy), digits_of(anatomy)
    joints = digits.joints(curls)
    mirror = np.array([1.0, -OUTWARD[side], 1.0])  # drawn for the right hand, thumb at +y
    starts, ends = (
        mirror
        * np.concatenate(
            [
                np.broadcast_to(fixed, (len(curls), *fixed.shape)),
                chain.reshape(len(curls), -1, 3),
            ],
            axis=1,
        )
        for fixed, chain in (
            (palm.starts_m, joints[:, :, :-1]),
            (palm.ends_m, joints[:, :, 1:]),
        )
    )
    return Capsules(starts, ends, np.concatenate([palm.radii_m, digits.radii_m.ravel()]))


def palm_bars(anatomy: Anatomy) -> Capsules:
    """The 4 bars of the right palm, hand frame."""
    broad = anatomy.hand_breadth_m / _AVERAGE_BREADTH_M
    long = anatomy.wrist_to_palm_m / _AVERAGE_PALM_M
    across, near, far = np.array(_PALM_BARS).T
    starts, ends = (
        np.column_stack([reach * long, across * broad, np.full(len(across), -0.001)])
        for reach in (near, far)
    )
    return Capsules(starts, ends, np.full(len(across), _PALM_RADIUS * broad))


def hand_capsules(anatomy: Anatomy, side: int, curls: Floats) -> Capsules:
    """Palm (4 bars), thumb and fingers (3 each) in the hand's frame for curls (5,)."""
    return _hand_capsules(anatomy, side, tuple(curls.tolist()))


def height_above_table(anatomy: Anatomy, side: int, rotation: Floats, curls: Floats) -> float:
    """Height of the palm's centre [m] above a surface on which the hand lies with this rotation."""
    shape = hand_capsules(anatomy, side, curls)
    return -shape.placed(np.zeros(3), rotation).lowest_m


@dataclass(frozen=True, eq=False)
class Shape:
    """The shape of an arm apart from its pose: 25 bars that meet the other arm, 58 points that
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
    radii = np.array([*(r * k for r in FORE_SLEEVE_M), wrist])
    # The round end of the last bar stands for the cuff's flat one.
    end = 1.0 - (_CUFF_M + 0.55 * wrist) / anatomy.forearm_m
    ends = np.array([0.0, 0.25, 0.5, 0.75, end])
    along = _FOREARM_POINTS * end
    # Fingers are chains: a bar that goes on from another starts at its end.
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
    """The shape of an arm with these curls (5,)."""
    return _arm_shape(anatomy, side, tuple(curls.tolist()))
