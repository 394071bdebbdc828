"""Whether rig.json's cameras show the 3-D keypoints where truth.parquet says they do."""

from __future__ import annotations

import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.camera import StereoRig, distort_points, project, to_camera
from pjpdaf.targets import HEAD
from sim.dataset.check.fault import Claim, Fault, gathered
from sim.dataset.check.frame_tables import FrameTables
from sim.dataset.files.layout import RIG, TRUTH
from sim.dataset.labels.records import KEYPOINTS, NOT_LABELLED
from sim.scene.world import CAMERAS

SAME_PX = 0.01  # pixels are computed in single precision, through the lens too
HEAD_MPS2 = 3.0  # acceleration of a head
_HEAD = np.array([target == HEAD for target, _ in KEYPOINTS])


def projection_faults(
    name: str, told: list[FrameTables], rig: StereoRig, skew_s: float
) -> list[Fault]:
    """rig.json's where most frames disagree with it, else truth.parquet's.

    With shutter skew the right view's keypoints are of another moment: there only the head's are
    compared, moved as its velocity tells, and only a fault of most frames is one.
    """
    faults = []
    for view, camera in enumerate(CAMERAS):
        later_s = skew_s if view == 1 else 0.0
        off = np.array([_off(frame, rig, view, later_s) for frame in told])
        wrong = np.flatnonzero(off > 0)
        if len(wrong) * 2 > len(off):
            worst = float(np.median(off[wrong])) + SAME_PX
            what = f"cameras.{camera} shows keypoints_m of {TRUTH} {worst:.3g} px off"
            faults.append(Fault(f"{name}/{RIG}", f"{what} keypoints_{camera}_px"))
        elif later_s == 0:
            kind = f"keypoints, {camera} view"
            claims = [
                Claim(
                    f"{name}/{TRUTH}",
                    kind,
                    i,
                    f"are {off[i] + SAME_PX:.3g} px off where {RIG} projects keypoints_m",
                )
                for i in wrong.tolist()
            ]
            faults += gathered(claims)
    return faults


def _off(frame: FrameTables, rig: StereoRig, view: int, later_s: float) -> float:
    """How much farther the worst keypoint is off than allowed [px]; 0 or less if none is."""
    camera = rig.cameras[view]
    points, said = frame.keypoints_m, frame.keypoints_px[view]
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
    off = np.linalg.norm(distort_points(camera, project(camera, points)) - said, axis=1)
    return float(np.max(np.nan_to_num(off - allowed, nan=np.inf)[used]))
