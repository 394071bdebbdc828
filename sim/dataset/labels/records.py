"""Labels of a frame beyond `sim.truth`: frozen records, numpy only."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import accumulate

import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Floats, Image
from pjpdaf.targets import HEAD, LEFT_HAND, RIGHT_HAND, TARGETS

HEAD_POINTS = ("head_centre", "chin")
HAND_POINTS = (
    "wrist",
    "palm_centre",
    "thumb_tip",
    "index_tip",
    "middle_tip",
    "ring_tip",
    "little_tip",
)
# All keypoints in their order everywhere: (target, name).
KEYPOINTS: tuple[tuple[int, str], ...] = (
    *((HEAD, name) for name in HEAD_POINTS),
    *((RIGHT_HAND, name) for name in HAND_POINTS),
    *((LEFT_HAND, name) for name in HAND_POINTS),
)
# Of each target, the index of the keypoint at its centre.
CENTRE_KEYPOINTS = tuple(
    KEYPOINTS.index((t, "palm_centre" if t else "head_centre")) for t in range(len(TARGETS))
)
# The joints of a hand in the usual order: from the wrist along each finger to its tip.
HAND_JOINTS = (
    "wrist",
    *(f"thumb_{joint}" for joint in ("cmc", "mcp", "ip", "tip")),
    *(
        f"{finger}_{joint}"
        for finger in ("index", "middle", "ring", "little")
        for joint in ("mcp", "pip", "dip", "tip")
    ),
)
# The points of a body in COCO's order, of which those of the legs have no labels.
COCO_BODY = (
    "nose",
    *(
        f"{side}_{part}"
        for part in ("eye", "ear", "shoulder", "elbow", "wrist", "hip", "knee", "ankle")
        for side in ("left", "right")
    ),
)
BODY_POINTS = COCO_BODY[:13]
# Skeletons in their order everywhere, with the names of their points.
BODY_SKELETON, HAND_SKELETONS = "person", ("right_hand", "left_hand")
SKELETONS: dict[str, tuple[str, ...]] = {
    BODY_SKELETON: BODY_POINTS,
    **dict.fromkeys(HAND_SKELETONS, HAND_JOINTS),
}
# Where the points of each skeleton are among those of all, one skeleton after the other.
SKELETON_SLICES = {
    name: slice(end - len(points), end)
    for (name, points), end in zip(
        SKELETONS.items(), accumulate(map(len, SKELETONS.values())), strict=True
    )
}
# Status of a keypoint in a view, as in COCO.
NOT_LABELLED, OCCLUDED, VISIBLE = 0, 1, 2
# Status of a pixel of a view in the other view.
NO_SURFACE, SEEN, HIDDEN, OUT_OF_FRAME = 0, 1, 2, 3


@dataclass(frozen=True, eq=False)
class Matches:
    """Positions in another picture of the surface that each pixel of a view shows.

    Of the rectified pair: disparity_px (h, w) float32, x_left - x_right >= 0, NaN where there is no
    surface or the real picture does not reach. Of the pictures as they are: places_px (h, w, 2)
    float32, pixels of the other picture, also outside it; NaN where there is no surface, and behind
    the other camera or beyond its lens. Of optical flow: places_px in another frame's picture.
    status (h, w) uint8: NO_SURFACE, SEEN, HIDDEN or OUT_OF_FRAME in the other picture.
    """

    status: NDArray[np.uint8]
    disparity_px: NDArray[np.float32] | None = None
    places_px: NDArray[np.float32] | None = None


@dataclass(frozen=True, eq=False)
class ViewLabels:
    """Labels of one view of T targets, I instance ids (0 ... highest), K keypoints, P points.

    depth_m (h, w) float32: planar z, NaN for nothing. instances (h, w) uint8: of `Instances`.
    amodal (T, h, w) bool: the target's skin with everything else removed. amodal_boxes_px (T, 4):
    x, y, width, height, 0-based, NaN where empty. truncation (T,): share of the amodal target that
    lies outside the picture, 1 where all of it does. hidden_px (T, I) int64: pixels of the amodal
    mask that show instance i instead. keypoints_px (K, 2): in the real picture, NaN behind the
    camera and beyond its lens; keypoint_status (K,) int8: NOT_LABELLED outside the picture,
    OCCLUDED or VISIBLE; skeleton_px (P, 2), skeleton_status (P,): the same of the points of
    SKELETONS, one skeleton after the other. objects_px (O,) int64: visible pixels of the objects.
    rectified, matches: `Matches` of the rectified pair and of the pictures as they are; classes
    (h, w) uint8: of `classes.CLASSES`; normals (h, w, 3) uint8: of `sim.camera.normals`; each None
    if not wanted.
    """

    depth_m: NDArray[np.float32]
    instances: NDArray[np.uint8]
    amodal: NDArray[np.bool_]
    amodal_boxes_px: Floats
    truncation: Floats
    hidden_px: NDArray[np.int64]
    keypoints_px: Floats
    keypoint_status: NDArray[np.int8]
    skeleton_px: Floats
    skeleton_status: NDArray[np.int8]
    objects_px: NDArray[np.int64]
    rectified: Matches | None = None
    matches: Matches | None = None
    classes: NDArray[np.uint8] | None = None
    normals: Image | None = None


@dataclass(frozen=True, eq=False)
class ObjectState:
    """An object at the moment of a frame, world: position_m (3,) of its base's centre,
    quaternion (4,) w, x, y, z, velocity_mps (3,).
    """

    name: str
    position_m: Floats
    quaternion: Floats
    velocity_mps: Floats


@dataclass(frozen=True, eq=False)
class FrameLabels:
    """Labels of a frame. quaternions (T, 4): w, x, y, z of the targets' own frames (`sim.pose`);
    keypoints_m (K, 3), skeleton_m (P, 3) [m]; all, and the objects, in the world, of the moment
    `Truth.time_s`. finger_angles_rad (2, 5, 3): of the right and the left hand's fingers, thumb
    first, the flexion of each joint from the wrist on, 0 for a straight finger.
    """

    quaternions: Floats
    keypoints_m: Floats
    skeleton_m: Floats
    finger_angles_rad: Floats
    views: tuple[ViewLabels, ViewLabels]
    objects: tuple[ObjectState, ...] = field(default=())


@dataclass(frozen=True, eq=False)
class FlowLabels:
    """Optical flow between two frames, `Matches` per view: of the first frame's pixels, forward,
    and of the second's, backward.
    """

    forward: tuple[Matches, Matches]
    backward: tuple[Matches, Matches]
