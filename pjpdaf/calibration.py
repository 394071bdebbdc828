"""Calibration files: intrinsics.yml and extrinsics.yml as OpenCV's stereo sample writes them.

Those of ROS and Kalibr are read too (`pjpdaf.calibration_formats`).
"""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path

import cv2
import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.calibration_formats import (
    Stereo,
    is_kalibr,
    is_ros,
    read_kalibr,
    read_opencv,
    read_ros,
)
from pjpdaf.camera import Camera, StereoRig
from pjpdaf.errors import BenchError, FileError
from pjpdaf.opencv_file import OpenCvFile

INTRINSICS, EXTRINSICS = "intrinsics.yml", "extrinsics.yml"
BASELINE_MAX_M = 10.0  # above this the file is in millimetres, or in squares


def read_rig(
    intrinsics: Path | str,
    extrinsics: Path | str | None = None,
    size_px: tuple[int, int] | None = None,
    unit_m: float = 1.0,
) -> StereoRig:
    """Read a rig, in the left camera's frame (left R_cw = I, t_cw = 0), from OpenCV YAML (or XML).

    intrinsics: file with M1 D1 M2 D2 (or K1 ...), or the folder that holds both files under their
    usual names; extrinsics: file with R T (default: beside the first under its usual name, or,
    where that file has R itself, that file). Or: two camera_info files of ROS, left and right; a
    camera chain of Kalibr, for both. size_px: width and height of the pictures, needed where the
    files have none; unit_m: length of T's unit [m], 0.001 for millimetres.

    Raises FileError naming file and key.
    """
    with ExitStack() as opened:

        def read(path: Path) -> OpenCvFile:
            file = OpenCvFile(path)
            opened.callback(file.close)
            return file

        first = Path(intrinsics)
        second = first / EXTRINSICS if first.is_dir() else first.with_name(EXTRINSICS)
        inner = read(first / INTRINSICS if first.is_dir() else first)
        if is_kalibr(inner):
            stereo = read_kalibr(inner)
        elif is_ros(inner):
            if extrinsics is None:
                raise FileError(inner.path, "is of one camera; give the other camera's file too")
            stereo = read_ros(inner, read(Path(extrinsics)))
        elif extrinsics is None and inner.has("R"):
            stereo = read_opencv(inner, inner)
        else:
            stereo = read_opencv(inner, read(second if extrinsics is None else Path(extrinsics)))
        return _rig_of(stereo, inner.path, Path(extrinsics or second), size_px, unit_m)


def _rig_of(
    stereo: Stereo, inner: Path, outer: Path, size_px: tuple[int, int] | None, unit_m: float
) -> StereoRig:
    T = stereo.T * unit_m
    length = float(np.linalg.norm(T))
    if length < 1e-6:
        raise FileError(outer, "T is zero; two cameras at the same place see no depth")
    if length > BASELINE_MAX_M:
        raise FileError(
            outer,
            f"T is {length:g} m long; metres are expected: calibrate with the square "
            "size in metres, or give the unit (0.001 m for millimetres)",
        )
    size = stereo.size_px or size_px
    if size is None:
        raise FileError(
            inner,
            "keys image_width and image_height are missing, so the size of the "
            "pictures must be given",
        )
    if size_px is not None and tuple(size_px) != size:
        raise FileError(
            inner,
            f"calibrated at {size[0]}x{size[1]} px (image_width, image_height), but "
            f"the pictures are {size_px[0]}x{size_px[1]}",
        )
    left = Camera(stereo.K[0], np.eye(3), np.zeros(3), *size, stereo.D[0])
    right = Camera(stereo.K[1], stereo.R, T, *size, stereo.D[1])
    return StereoRig(left, right)


def view_order_doubt(rig: StereoRig) -> str:
    """Why left and right seem to be exchanged, in one sentence; "" where they do not."""
    T = rig.T
    if T[0] > 0 and abs(T[0]) == np.abs(T).max():
        return (
            f"by this calibration the right camera is {1000 * T[0]:.0f} mm to the left of the "
            "left one (T_x is above 0): left and right are exchanged, or --left and --right are"
        )
    return ""


def write_rig(rig: StereoRig, folder: Path | str) -> tuple[Path, Path]:
    """Write intrinsics.yml and extrinsics.yml as OpenCV's stereo sample does; returns their paths.

    The world frame of the rig is not kept: R, T lead from the left camera to the right. Beside the
    sample's keys stand image_width and image_height, which it omits.
    """
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    left, right = rig.left, rig.right
    if (left.width_px, left.height_px) != (right.width_px, right.height_px):
        raise BenchError(
            "OpenCV's stereo files have one picture size, the cameras have "
            f"{left.width_px}x{left.height_px} and {right.width_px}x{right.height_px}."
        )
    T = np.array(rig.T).reshape(3, 1)
    R1, R2, P1, P2, Q, *_ = rectify(rig)
    inner: dict[str, Floats] = {
        "M1": np.array(left.K),
        "D1": _row(left.distortion),
        "M2": np.array(right.K),
        "D2": _row(right.distortion),
    }
    outer: dict[str, Floats] = {
        "R": np.array(rig.R),
        "T": T,
        "R1": R1,
        "R2": R2,
        "P1": P1,
        "P2": P2,
        "Q": Q,
    }
    paths = folder / INTRINSICS, folder / EXTRINSICS
    for path, keys in zip(paths, (inner, outer), strict=True):
        storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_WRITE)
        if not storage.isOpened():
            raise FileError(path, "cannot be written")
        for key, value in keys.items():
            storage.write(key, value)
        if keys is inner:
            storage.write("image_width", left.width_px)
            storage.write("image_height", left.height_px)
        storage.release()
    return paths


def rectify(
    rig: StereoRig,
) -> tuple[Floats, Floats, Floats, Floats, Floats, object, object]:
    """Rectify by cv2.stereoRectify, flags as in the stereo sample: R1, R2, P1, P2, Q, two ROIs."""
    left, right = rig.left, rig.right
    rectified: tuple[Floats, Floats, Floats, Floats, Floats, object, object] = cv2.stereoRectify(
        np.array(left.K),
        _row(left.distortion),
        np.array(right.K),
        _row(right.distortion),
        (left.width_px, left.height_px),
        np.array(rig.R),
        np.array(rig.T).reshape(3, 1),  # OpenCV 5 wants a column
        flags=cv2.CALIB_ZERO_DISPARITY,
        alpha=1,
    )
    return rectified


def _row(distortion: Floats) -> Floats:
    """Coefficients as a row (1, n), as the sample writes them; none become five zeros."""
    return np.array(distortion if len(distortion) else np.zeros(5)).reshape(1, -1)
