"""skeletons.parquet against itself and truth.parquet: rigid bones, joint angles, shared points."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.targets import HANDS, TARGETS
from sim.dataset.check.fault import FrameFault
from sim.dataset.check.frame_tables import FrameTables, rotation_of
from sim.dataset.files.layout import SKELETON
from sim.dataset.labels.records import (
    BODY_POINTS,
    BODY_SKELETON,
    HAND_JOINTS,
    HAND_SKELETONS,
    KEYPOINTS,
    SKELETON_SLICES,
)

SAME_M, SAME_RAD = 1e-7, 1e-5  # of numbers with all their digits; an arc cosine near 0 has half
_BY_SIDE = ("left", "right")
# Points of the body that are as far apart in every frame.
_RIGID_PAIRS = {
    "length of an arm's bone": [
        (f"{side}_{a}", f"{side}_{b}")
        for side in _BY_SIDE
        for a, b in (("shoulder", "elbow"), ("elbow", "wrist"))
    ],
    "shape of the face": [("nose", f"{side}_{p}") for side in _BY_SIDE for p in ("eye", "ear")],
}
_RIGID_INDICES = {
    kind: np.array([[BODY_POINTS.index(point) for point in pair] for pair in pairs])
    for kind, pairs in _RIGID_PAIRS.items()
}


def check_skeletons(name: str, tables: list[FrameTables]) -> Iterator[FrameFault]:
    """Check the points of all frames against those of the first, and the angles against them."""
    for i, frame in enumerate(tables):
        for kind, off, least, unit in _differences(frame, tables[0]):
            if not off <= least:
                text = f"is off by {off:.3g} {unit}"
                yield FrameFault(f"{name}/{SKELETON}", kind, i, text)


def _differences(frame: FrameTables, first: FrameTables) -> Iterator[tuple[str, float, float, str]]:
    """Kind, greatest difference, tolerance and unit of each comparison of a frame."""
    places, before = frame.skeleton_m, first.skeleton_m
    body, body_before = (points[SKELETON_SLICES[BODY_SKELETON]] for points in (places, before))
    for kind, pairs in _RIGID_INDICES.items():
        off_m = _worst(_lengths(body, pairs) - _lengths(body_before, pairs))
        yield kind, off_m, SAME_M, "m"
    for h, (target, hand) in enumerate(zip(HANDS, HAND_SKELETONS, strict=True)):
        joints, start = (points[SKELETON_SLICES[hand]] for points in (places, before))
        named = dict(zip(HAND_JOINTS, joints, strict=True))
        shared = [k for k, (t, p) in enumerate(KEYPOINTS) if t == target and p in named]
        own = np.array([named[KEYPOINTS[k][1]] for k in shared])
        off_m = _worst(frame.keypoints_m[shared] - own)
        yield f"wrist and tips of {hand} in truth.parquet", off_m, SAME_M, "m"
        side = hand.partition("_")[0]
        wrist = body[BODY_POINTS.index(f"{side}_wrist")]
        yield f"{side}_wrist of {BODY_SKELETON}", _worst(wrist - joints[0]), SAME_M, "m"
        bones, bones_before = _bones(joints), _bones(start)
        off_m = _worst(np.linalg.norm(bones, axis=-1) - np.linalg.norm(bones_before, axis=-1))
        yield f"length of a bone of {hand}", off_m, SAME_M, "m"
        angles, angles_before = frame.finger_angles_rad[h], first.finger_angles_rad[h]
        between = _angle(bones[:, :-1], bones[:, 1:])
        off_rad = _worst(between - np.abs(angles[:, 1:]))
        yield f"finger_angles_rad of {hand}, between bones", off_rad, SAME_RAD, "rad"
        turned = [
            _in_palm(f, TARGETS[target], b) for f, b in ((frame, bones), (first, bones_before))
        ]
        off_rad = _worst(_angle(turned[0], turned[1]) - np.abs(angles[:, 0] - angles_before[:, 0]))
        yield f"finger_angles_rad of {hand}, in the palm", off_rad, SAME_RAD, "rad"


def _bones(joints: Floats) -> Floats:
    """The three bones (5, 3, 3) of each finger, from joint to joint, world [m]."""
    return np.diff(joints[1:].reshape(5, 4, 3), axis=1)


def _in_palm(frame: FrameTables, target: str, bones: Floats) -> Floats:
    """The first bones (5, 3) of the fingers in the hand's frame."""
    turn = rotation_of(frame.rows[TARGETS.index(target)])
    return np.asarray(turn.inv().apply(bones[:, 0]))


def _angle(a: Floats, b: Floats) -> Floats:
    """Angle (...,) between vectors (..., 3) [rad]."""
    across = np.linalg.norm(np.cross(a, b), axis=-1)
    return np.asarray(np.arctan2(across, (a * b).sum(axis=-1)))


def _lengths(points: Floats, pairs: np.ndarray) -> Floats:
    return np.asarray(np.linalg.norm(points[pairs[:, 0]] - points[pairs[:, 1]], axis=1))


def _worst(differences: Floats) -> float:
    return float(np.abs(np.nan_to_num(differences, nan=np.inf)).max(initial=0.0))
