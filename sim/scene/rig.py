"""Two cameras in front of the person: RigSpec -> StereoRig, and Camera -> MuJoCo's arguments."""

from __future__ import annotations

from typing import Any

import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.camera import Camera, StereoRig
from sim.specs import RigSpec

# Camera axes (OpenCV: x right, y down, z forward) of a level camera that looks along -x of the
# world: its right is the person's left, so the person's left hand is on the right of the picture.
LEVEL_R_CW = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, -1.0], [-1.0, 0.0, 0.0]])
PIXEL_SIZE_M = 1e-5  # any value does: only ratios to it enter


def stereo_rig(spec: RigSpec) -> StereoRig:
    """The rig in the world frame: x_right = R x_left + T, T = (-baseline, 0, 0) without vergence.

    Left and right are those of the robot that looks at the person. Each camera turns inwards by
    half the vergence about its own vertical axis, then both are tilted as one head.
    """
    K = np.array(
        [
            [spec.focal_px, 0.0, (spec.width_px - 1) / 2 + spec.principal_offset_px[0]],
            [0.0, spec.focal_px, (spec.height_px - 1) / 2 + spec.principal_offset_px[1]],
            [0.0, 0.0, 1.0],
        ]
    )
    middle_w = np.array([spec.distance_m, 0.0, spec.height_m])
    head_R_cw = turn_x(spec.tilt_rad) @ LEVEL_R_CW
    cameras = []
    for side in (-1.0, 1.0):
        centre_w = middle_w + head_R_cw.T @ np.array([side * spec.baseline_m / 2, 0.0, 0.0])
        R_cw = turn_y(side * spec.vergence_rad / 2) @ head_R_cw
        cameras.append(
            Camera(
                K=K,
                R_cw=R_cw,
                t_cw=-R_cw @ centre_w,
                width_px=spec.width_px,
                height_px=spec.height_px,
                distortion=np.array(spec.distortion, dtype=np.float64),
            )
        )
    return StereoRig(left=cameras[0], right=cameras[1])


def turn_x(angle_rad: float) -> Floats:
    """Rotation matrix (3, 3) about x."""
    c, s = np.cos(angle_rad), np.sin(angle_rad)
    return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])


def turn_y(angle_rad: float) -> Floats:
    """Rotation matrix (3, 3) about y."""
    c, s = np.cos(angle_rad), np.sin(angle_rad)
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])


def mujoco_camera(camera: Camera) -> dict[str, Any]:
    """Arguments of MjSpec's add_camera for any pinhole: off-centre, fx != fy, any pose.

    MuJoCo's camera looks along -z with y up. Its principal point counts from the picture's middle,
    both axes reversed (since 3.6), and resolution, sensor size and focal length must all be given.
    The lens distortion is left to the caller. Raises ValueError for a skewed K.
    """
    K = camera.K
    if K[0, 1] != 0 or K[1, 0] != 0:
        raise ValueError(f"MuJoCo has no camera with skew, got K[0, 1] = {K[0, 1]}")
    width, height = camera.width_px, camera.height_px
    right, up = camera.R_cw[0], -camera.R_cw[1]
    return {
        "pos": camera.centre_w.tolist(),
        "xyaxes": [*right, *up],
        "resolution": [width, height],
        "sensor_size": [width * PIXEL_SIZE_M, height * PIXEL_SIZE_M],
        "focal_pixel": [K[0, 0], K[1, 1]],
        "principal_pixel": [(width - 1) / 2 - K[0, 2], (height - 1) / 2 - K[1, 2]],
    }
