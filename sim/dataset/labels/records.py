"""Labels of a frame beyond `sim.truth`: frozen records, numpy only."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Floats
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
# Status of a keypoint in a view, as in COCO.
NOT_LABELLED, OCCLUDED, VISIBLE = 0, 1, 2
# Status of a pixel of a view in the other view.
NO_SURFACE, SEEN, HIDDEN, OUT_OF_FRAME = 0, 1, 2, 3


@dataclass(frozen=True, eq=False)
class Matches:
    """Positions in the other view of the surface that each pixel of a view shows.

    Of the rectified pair: disparity_px (h, w) float32, x_left - x_right >= 0, NaN where there is no
    surface or the real picture does not reach. Of the pictures as they are: places_px (h, w, 2)
    float32, pixels of the other picture, also outside it; NaN where there is no surface, and behind
    the other camera or beyond its lens. status (h, w) uint8: NO_SURFACE, SEEN, HIDDEN or
    OUT_OF_FRAME in the other view.
    """

    status: NDArray[np.uint8]
    disparity_px: NDArray[np.float32] | None = None
    places_px: NDArray[np.float32] | None = None


@dataclass(frozen=True, eq=False)
class ViewLabels:
    """Labels of one view of T targets, I instance ids (0 ... highest), K keypoints.

    depth_m (h, w) float32: planar z, NaN for nothing. instances (h, w) uint8: of `Instances`.
    amodal (T, h, w) bool: the target's skin with everything else removed. amodal_boxes_px (T, 4):
    x, y, width, height, 0-based, NaN where empty. truncation (T,): share of the amodal target that
    lies outside the picture, 1 where all of it does. hidden_px (T, I) int64: pixels of the amodal
    mask that show instance i instead. keypoints_px (K, 2): in the real picture, NaN behind the
    camera and beyond its lens; keypoint_status (K,) int8: NOT_LABELLED outside the picture,
    OCCLUDED or VISIBLE. objects_px (O,) int64: visible pixels of the objects. rectified, matches:
    `Matches` of the rectified pair and of the pictures as they are, None if not wanted.
    """

    depth_m: NDArray[np.float32]
    instances: NDArray[np.uint8]
    amodal: NDArray[np.bool_]
    amodal_boxes_px: Floats
    truncation: Floats
    hidden_px: NDArray[np.int64]
    keypoints_px: Floats
    keypoint_status: NDArray[np.int8]
    objects_px: NDArray[np.int64]
    rectified: Matches | None = None
    matches: Matches | None = None


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
    keypoints_m (K, 3) [m]; both, and the objects, in the world, of the moment `Truth.time_s`.
    """

    quaternions: Floats
    keypoints_m: Floats
    views: tuple[ViewLabels, ViewLabels]
    objects: tuple[ObjectState, ...] = field(default=())
