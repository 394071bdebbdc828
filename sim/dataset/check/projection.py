"""The 3-D keypoints of truth.parquet, projected by rig.json's cameras, against its pixels."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.camera import StereoRig, distort_points, project, to_camera
from pjpdaf.targets import HEAD
from sim.dataset.check.fault import Fault, FrameFault
from sim.dataset.check.frame_tables import FrameTables
from sim.dataset.files.layout import RIG, SKELETON, TRUTH
from sim.dataset.labels.records import KEYPOINTS, NOT_LABELLED
from sim.scene.world import CAMERAS

SAME_PX = 0.01  # pixels are computed in single precision, through the lens too
HEAD_MPS2 = 3.0  # acceleration of a head
_HEAD = np.array([target == HEAD for target, _ in KEYPOINTS])


def check_projection(
    name: str, tables: list[FrameTables], rig: StereoRig, skew_s: float
) -> Iterator[Fault | FrameFault]:
    """Check the keypoints; rig.json is at fault where most frames differ, else truth.parquet.

    With shutter skew the right view's keypoints are of another moment: there only the head's are
    compared, moved by its velocity, and only a difference in most frames is a fault.
    """
    for view, camera in enumerate(CAMERAS):
        later_s = skew_s if view == 1 else 0.0
        excess_px = np.array([_excess_px(frame, rig, view, later_s) for frame in tables])
        wrong = np.flatnonzero(excess_px > 0)
        if len(wrong) * 2 > len(tables):
            middle_px = float(np.median(excess_px[wrong])) + SAME_PX
            text = f"cameras.{camera} shows keypoints_m of {TRUTH} {middle_px:.3g} px off"
            yield Fault(f"{name}/{RIG}", f"{text} keypoints_{camera}_px")
        elif later_s == 0:
            kind = f"keypoints, {camera} view"
            for i in wrong.tolist():
                off_px = excess_px[i] + SAME_PX
                text = f"are {off_px:.3g} px off where {RIG} projects keypoints_m"
                yield FrameFault(f"{name}/{TRUTH}", kind, i, text)


def _excess_px(frame: FrameTables, rig: StereoRig, view: int, later_s: float) -> float:
    """Distance of the worst keypoint above the allowed [px]; 0 or less if all are right."""
    camera = rig.cameras[view]
    points, pixels = frame.keypoints_m, frame.keypoints_px[view]
    used = frame.keypoint_status[view] != NOT_LABELLED
    allowed: Floats = np.full(len(points), SAME_PX)
    if later_s > 0:
        used &= _HEAD
        speed = float(np.linalg.norm(frame.truth.velocities_mps[HEAD]))
        points = points + later_s * frame.truth.velocities_mps[HEAD]
        moved_m = later_s * speed + HEAD_MPS2 * later_s**2
        allowed = allowed + camera.K[0, 0] * moved_m / to_camera(camera, points)[:, 2]
    if not used.any():
        return 0.0
    off = np.linalg.norm(distort_points(camera, project(camera, points)) - pixels, axis=1)
    return float(np.max(np.nan_to_num(off - allowed, nan=np.inf)[used]))


def check_skeleton_pixels(
    name: str, tables: list[FrameTables], rig: StereoRig, skew_s: float
) -> Iterator[FrameFault]:
    """Check the pixels of skeletons.parquet against its places, by cameras without fault.

    With shutter skew the right view's pixels are of another moment, and are not compared.
    """
    for view, camera in enumerate(CAMERAS):
        if view == 1 and skew_s > 0:
            continue
        own = rig.cameras[view]
        for i, frame in enumerate(tables):
            used = frame.skeleton_status[view] != NOT_LABELLED
            expected = distort_points(own, project(own, frame.skeleton_m[used]))
            off = np.linalg.norm(expected - frame.skeleton_px[view][used], axis=1)
            off_px = float(np.nan_to_num(off, nan=np.inf).max(initial=0.0))
            if off_px > SAME_PX:
                text = f"are {off_px:.3g} px off where {RIG} projects points_m"
                yield FrameFault(f"{name}/{SKELETON}", f"points, {camera} view", i, text)
