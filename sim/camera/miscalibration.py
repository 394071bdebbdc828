"""The calibration that a tracker is given, where it is not the rig that films."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.camera import Camera, StereoRig
from sim.specs import CalibrationError


def miscalibrated(rig: StereoRig, error: CalibrationError) -> StereoRig:
    """The rig as this faulty calibration has it.

    The left camera keeps its place and direction. The right camera stands further away along the
    line between the two by the share `baseline`, and is turned about its own axes; both focal
    lengths are longer by the share `focal`. Lenses and principal points are right.
    """
    if error == CalibrationError():
        return rig
    turn = cv2.Rodrigues(np.array(error.rotation_rad))[0]
    right_w = rig.left.centre_w + (1 + error.baseline) * (rig.right.centre_w - rig.left.centre_w)
    return StereoRig(
        left=_moved(rig.left, rig.left.centre_w, rig.left.R_cw, error.focal),
        right=_moved(rig.right, right_w, turn @ rig.right.R_cw, error.focal),
    )


def _moved(camera: Camera, centre_w: Floats, R_cw: Floats, focal: float) -> Camera:
    K = np.array(camera.K)
    K[0, 0] *= 1 + focal
    K[1, 1] *= 1 + focal
    return replace(camera, K=K, R_cw=R_cw, t_cw=-R_cw @ centre_w)
