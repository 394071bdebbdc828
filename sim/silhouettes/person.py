"""The person's shapes over a pose track: head, hands, sleeves, trunk."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.targets import HEAD
from sim.anatomy import Anatomy
from sim.contact.arm_shape import digits_of, palm_bars
from sim.contact.capsules import Capsules
from sim.person.geoms import HAND_TARGETS
from sim.person.hair import outline_points
from sim.person.head import beard_points
from sim.person.kinematics import OUTWARD
from sim.person.sleeves import (
    BARE_WRIST,
    FORE_SKIN_M,
    FORE_SLEEVE_M,
    ROLLED_SLEEVE,
    SHORT_SLEEVE,
    UPPER_SKIN_M,
    UPPER_SLEEVE_M,
    WRIST_M,
)
from sim.person.torso import COLLAR_TOP_M, torso_grid
from sim.silhouettes.pose_track import PoseTrack
from sim.silhouettes.shapes import BARE, CLOTHED, TARGET_PAINT, Bars, Hull, bars_of, joined
from sim.specs import RGB, Appearance
from sim.surfaces.shapes import extremes

_SHARES = (0.0, 0.25, 0.5, 0.75, 1.0)  # of a bone, at which `sim.person.sleeves` has its radii
_CUFF_M = 0.009  # a long sleeve's cuff ends this much before the wrist, flat
_FLAT_END = 0.55  # of its radius, by which a bar is shorter than the flat end it stands for
# Bars of the wrist of an average hand: beside the middle, along the hand.
_WRIST_ACROSS_M, _WRIST_X_M, _WRIST_RADIUS_M = (-0.0095, 0.0095), (-0.074, -0.050), 0.0165
# How much nearer than their mean they count: the neck is before the hair, and seen down to the
# front of the collar's rim.
_HAIR_M, _NECK_M, _TRUNK_M = -0.08, 0.04, -0.02
_BEARD_M = 0.03
_RIM_M = 0.047  # radius at which neck and collar meet
_TURN = np.linspace(0.0, 2.0 * np.pi, 13)[:-1]
_CIRCLE = np.column_stack([np.cos(_TURN), np.sin(_TURN)])


def person_bars(track: PoseTrack, anatomy: Anatomy, appearance: Appearance) -> Bars:
    """Hands, forearms and upper arms as bars."""
    parts = [
        part
        for side in (0, 1)
        for part in (
            _hand(track, anatomy, side),
            *_arm(track, anatomy, appearance.sleeves, side),
        )
    ]
    return joined(parts)


def _hand(track: PoseTrack, anatomy: Anatomy, side: int) -> Bars:
    """Palm (4 bars), thumb and fingers (3 each)."""
    palm, digits = _with_wrist(palm_bars(anatomy), anatomy), digits_of(anatomy)
    joints = digits.joints_over(track.curls[:, side])
    frames = len(joints)
    mirror = np.array([1.0, -OUTWARD[side], 1.0])
    ends = []
    for fixed, chain in ((palm.starts_m, joints[:, :, :-1]), (palm.ends_m, joints[:, :, 1:])):
        still = np.broadcast_to(fixed, (frames, *fixed.shape))
        drawn = np.concatenate([still, chain.reshape(frames, -1, 3)], axis=1)
        ends.append(track.hands[side].moved(mirror * drawn))
    of_palm, of_joints = palm.radii_m, digits.joint_radii_m
    radii = np.column_stack(
        [
            np.concatenate([of_palm, of_joints[:, :-1].ravel()]),
            np.concatenate([of_palm, of_joints[:, 1:].ravel()]),
        ]
    )
    return bars_of(ends[0], ends[1], radii, TARGET_PAINT + HAND_TARGETS[side])


def _with_wrist(palm: Capsules, anatomy: Anatomy) -> Capsules:
    """The palm's bars and two of the wrist, which shows below the cuff."""
    broad, long = anatomy.hand_breadth_m / 0.0851, anatomy.wrist_to_palm_m / 0.0774
    across = np.array(_WRIST_ACROSS_M) * broad
    ends = [np.column_stack([np.full(2, x * long), across, np.zeros(2)]) for x in _WRIST_X_M]
    return Capsules(
        np.concatenate([palm.starts_m, ends[0]]),
        np.concatenate([palm.ends_m, ends[1]]),
        np.concatenate([palm.radii_m, np.full(2, _WRIST_RADIUS_M * broad)]),
    )


def _arm(track: PoseTrack, anatomy: Anatomy, sleeves: str, side: int) -> list[Bars]:
    """Forearm and upper arm, clothed and bare stretches."""
    k = anatomy.stature_m / 1.72
    wrist = WRIST_M * anatomy.hand_breadth_m / 0.0851
    shoulder, elbow = track.shoulders_m[:, side], track.elbows_m[:, side]
    fore = elbow, track.wrists_m[:, side]
    upper = shoulder, elbow
    cloth = np.array([*(r * k for r in FORE_SLEEVE_M), wrist])
    skin = np.array([*(r * k for r in FORE_SKIN_M), BARE_WRIST * wrist])
    above, bare_above = k * np.array(UPPER_SLEEVE_M), k * np.array(UPPER_SKIN_M)
    cuff = 1.0 - (_CUFF_M + _FLAT_END * wrist) / anatomy.forearm_m
    if sleeves == "long":
        return [
            _stretch(*upper, above, (0.1, 0.5, 1.0), CLOTHED),
            _stretch(*fore, cloth, (0.0, 0.3, 0.65, cuff), CLOTHED),
        ]
    if sleeves == "rolled":
        return [
            _stretch(*upper, above, (0.1, 0.5, 1.0), CLOTHED),
            _stretch(*fore, skin, (ROLLED_SLEEVE, 0.65, 1.0), BARE),
            _stretch(*fore, 1.06 * cloth, (0.0, ROLLED_SLEEVE - 0.1), CLOTHED),
        ]
    return [
        _stretch(*fore, skin, (0.0, 0.3, 0.65, 1.0), BARE),
        _stretch(*upper, bare_above, (SHORT_SLEEVE, 1.0), BARE),
        _stretch(*upper, 1.02 * above, (0.1, SHORT_SLEEVE - 0.1), CLOTHED),
    ]


def _stretch(
    start_m: Floats, end_m: Floats, radii_m: Floats, shares: tuple[float, ...], paint: int
) -> Bars:
    """A chain of bars along a bone (F, 3) to (F, 3), between shares of its length."""
    along = np.array(shares)
    points = start_m[:, None] + along[:, None] * (end_m - start_m)[:, None]
    radii = np.interp(along, _SHARES, radii_m)
    return bars_of(points[:, :-1], points[:, 1:], np.column_stack([radii[:-1], radii[1:]]), paint)


def _neck(track: PoseTrack, anatomy: Anatomy) -> Hull:
    """The neck, skin of the head, from a ring below the chin down to the collar's rim."""
    k = anatomy.head_breadth_m / 0.1522
    above = track.head.moved(_ring(0.0435 * k, -0.008, -0.050))
    below = track.torso.moved(_ring(_RIM_M, 0.004, COLLAR_TOP_M))
    return Hull(np.concatenate([above, below], axis=1), TARGET_PAINT + HEAD, _NECK_M)


def _ring(radius_m: float, x_m: float, z_m: float) -> Floats:
    return np.column_stack([radius_m * _CIRCLE + [x_m, 0.0], np.full(len(_CIRCLE), z_m)])


def person_hulls(
    track: PoseTrack,
    anatomy: Anatomy,
    appearance: Appearance,
    table_height_m: float,
    clothes: bool = True,
) -> list[Hull]:
    """Hair, bare face with ears and neck; with clothes, collar and trunk above the table."""
    bare, hair = outline_points(anatomy, appearance.hair)
    k = anatomy.head_breadth_m / 0.1522
    if appearance.hair != "long":
        ears = k * np.array(
            [[-0.008, y * w, z - 0.006] for y in (-1, 1) for w, z in _EAR], dtype=np.float64
        )
        bare = np.concatenate([bare, ears])
    hulls = [Hull(track.head.moved(bare), TARGET_PAINT + HEAD)]
    if appearance.beard:
        beard = track.head.moved(beard_points(anatomy))
        hulls.append(Hull(beard, CLOTHED, _BEARD_M))
    if len(hair):
        hulls.append(Hull(track.head.moved(hair), CLOTHED, _HAIR_M))
        share = _like_skin(appearance.hair_rgb)
        if share > 0.0:
            middle = hair.mean(axis=0) + _LIT_M
            lit = track.head.moved(middle + np.sqrt(share) * (hair - middle))
            hulls.append(Hull(lit, BARE, _HAIR_M + 0.02))
    hulls.append(_neck(track, anatomy))
    if not clothes:  # they are behind head and hands
        return hulls
    lowest = table_height_m - _SEEN_BELOW_M - anatomy.mid_shoulder_height_m
    pieces = _trunk(anatomy, lowest)
    hulls += [Hull(track.torso.moved(piece), CLOTHED, _TRUNK_M) for piece in pieces]
    rims = [_ring(0.0565, 0.004, z_m) for z_m in (0.045, COLLAR_TOP_M)]
    collar = Hull(track.torso.moved(np.concatenate(rims)), CLOTHED, _TRUNK_M)
    return [*hulls, collar]


def _like_skin(hair_rgb: RGB) -> float:
    """The share of the hair that a detector takes for skin: none of dark and of grey hair.

    Brown and blond hair in the light has the hue and the saturation of skin. Measured: 0.02 up to
    a red of 0.19, 0.2 at 0.21, 0.45 from 0.24 on.
    """
    red, _, blue = hair_rgb
    if red - blue < _GREY * red:
        return 0.0
    return _MOST_LIKE_SKIN * min(max((red - _DARK_RED) / (_LIGHT_RED - _DARK_RED), 0.0), 1.0)


_DARK_RED, _LIGHT_RED, _GREY, _MOST_LIKE_SKIN = 0.19, 0.24, 0.15, 0.45
_LIT_M = np.array([0.02, 0.0, 0.02])  # lit from above and before
_EAR = ((0.0765, 0.025), (0.0805, 0.0), (0.0765, -0.025))  # half breadth, height from its middle


_SEEN_BELOW_M = 0.03  # of the trunk, below the table's height, over its near edge


@lru_cache(maxsize=64)
def _trunk(anatomy: Anatomy, lowest_m: float) -> tuple[Floats, ...]:
    """Convex pieces of the trunk above a height, torso frame: belly, chest, shoulders."""
    vertices = torso_grid(anatomy).reshape(-1, 3)[::2]
    vertices = vertices[vertices[:, 2] >= lowest_m]
    z = vertices[:, 2] / (anatomy.stature_m / 1.72)
    pieces = [vertices[(z >= low) & (z <= high)] for low, high in _SLICES]
    return tuple(extremes(piece) for piece in pieces if len(piece))


_SLICES = ((-0.57, -0.20), (-0.23, -0.005), (-0.03, 0.06))  # of the average trunk
