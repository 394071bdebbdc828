"""Stereo calibrations in the formats that people have: OpenCV, ROS camera_info, Kalibr."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.camera import DISTORTION_LENGTHS
from pjpdaf.errors import FileError
from pjpdaf.opencv_file import OpenCvFile

# Names of a key in use: the sample stereo_calib's, and those of many scripts.
K_NAMES = tuple((f"M{n}", f"K{n}", f"cameraMatrix{n}") for n in (1, 2))
D_NAMES = tuple((f"D{n}", f"distCoeffs{n}", f"dist{n}") for n in (1, 2))
ROTATION_TOLERANCE = 1e-3  # a matrix typed with four digits is still meant to be a rotation
DISTORTION_MAX = 1000.0  # of a coefficient; rational models have some tens
PIXELS_MAX = 1e6  # focal lengths and principal points
SIDE_MAX = 20_000  # of a picture [px]

Size = tuple[int, int]


@dataclass(frozen=True, eq=False)
class Stereo:
    """Intrinsics K (3, 3), distortion D (n,) of both cameras; X_right = R X_left + T.

    T in the unit of the file; size_px: width and height, None where the file has none.
    """

    K: tuple[Floats, Floats]
    D: tuple[Floats, Floats]
    R: Floats
    T: Floats
    size_px: Size | None


def is_ros(file: OpenCvFile) -> bool:
    """Whether the file is the camera_info of one camera, as ROS's calibration writes it."""
    return file.has("camera_matrix", "data") and file.has("projection_matrix")


def is_kalibr(file: OpenCvFile) -> bool:
    """Whether the file is a camera chain of Kalibr."""
    return file.has("cam0", "intrinsics")


def read_opencv(inner: OpenCvFile, outer: OpenCvFile) -> Stereo:
    """M1 D1 M2 D2 (or K1 ...) of one file, R T of another, which may be the same."""
    K = tuple(_intrinsics(inner, (inner.first(*names) or names[0],)) for names in K_NAMES)
    D = tuple(_distortion(inner, (inner.first(*names) or names[0],)) for names in D_NAMES)
    return Stereo(
        (K[0], K[1]), (D[0], D[1]), _rotation(outer, ("R",)), _translation(outer), _size(inner)
    )


def read_ros(left: OpenCvFile, right: OpenCvFile) -> Stereo:
    """A pair of camera_info files: their rectification R1, R2 and P2 say where the cameras are.

    A point is R1 X_left in the rectified left frame and R2 X_right in the right, P2[0, 3] / fx
    further along x: so R = R2^T R1 and T = R2^T (P2[0, 3] / fx, 0, 0).
    """
    K, D, R, sizes = [], [], [], []
    for file in (left, right):
        if not is_ros(file):
            raise FileError(file.path, "is not the camera_info of a camera, as the other file is")
        model = file.text("distortion_model")
        if model not in ("", "plumb_bob", "rational_polynomial"):
            raise FileError(
                file.path,
                f"distortion_model {model[:40]!r}: plumb_bob or rational_polynomial needed",
            )
        K.append(_intrinsics(file, ("camera_matrix",)))
        D.append(_distortion(file, ("distortion_coefficients",)))
        R.append(_rotation(file, ("rectification_matrix",)))
        sizes.append(_size(file))
    if sizes[0] != sizes[1]:
        raise FileError(right.path, f"pictures of {sizes[1]} px, the left camera's {sizes[0]} px")
    P = _shaped(right, ("projection_matrix",), (3, 4))
    if not P[0, 0] > 0 or P[0, 3] == 0:
        raise FileError(
            right.path,
            "projection_matrix has no baseline ([0, 3] is 0): the cameras were calibrated one by "
            "one; calibrate them as a stereo pair, or take `pjpdaf-bench calibrate`",
        )
    T = R[1].T @ np.array([P[0, 3] / P[0, 0], 0.0, 0.0])
    return Stereo((K[0], K[1]), (D[0], D[1]), R[1].T @ R[0], T, sizes[0])


def read_kalibr(file: OpenCvFile) -> Stereo:
    """cam0 (left) and cam1 of a chain; T_cn_cnm1 of cam1 leads from cam0 to cam1."""
    K, D, sizes = [], [], []
    for name in ("cam0", "cam1"):
        if not file.has(name):
            raise FileError(file.path, f"has no {name}: a chain of two cameras is needed")
        models = (file.text(name, "camera_model"), file.text(name, "distortion_model"))
        if models not in (("pinhole", "radtan"), ("pinhole", "none")):
            raise FileError(
                file.path,
                f"{name} is {' '.join(models)[:60]}: pinhole radtan is needed; "
                "calibrate with --models pinhole-radtan",
            )
        values = file.numbers(name, "intrinsics")
        if len(values) != 4:
            raise FileError(file.path, f"{name}.intrinsics must be fx, fy, cx, cy")
        fx, fy, cx, cy = values
        K.append(_checked_intrinsics(file, name, np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1.0]])))
        lens = file.numbers(name, "distortion_coeffs") if models[1] == "radtan" else np.zeros(0)
        D.append(_checked_distortion(file, f"{name}.distortion_coeffs", lens))
        side = file.numbers(name, "resolution")
        if len(side) != 2:
            raise FileError(file.path, f"{name}.resolution must be width, height")
        sizes.append(_checked_size(file, side.tolist()))
    if sizes[0] != sizes[1]:
        raise FileError(file.path, "cam0 and cam1 have pictures of different size")
    M = file.table("cam1", "T_cn_cnm1")
    if M.shape != (4, 4):
        raise FileError(file.path, "cam1.T_cn_cnm1 must be 4x4")
    R = checked_rotation(file, "cam1.T_cn_cnm1", M[:3, :3])
    return Stereo((K[0], K[1]), (D[0], D[1]), R, M[:3, 3], sizes[0])


def _shaped(file: OpenCvFile, key: tuple[str, ...], shape: tuple[int, int]) -> Floats:
    matrix = file.matrix(*key)
    if matrix.shape != shape:
        raise FileError(
            file.path,
            f"{'.'.join(key)} must be {shape[0]}x{shape[1]}, got {_times(matrix.shape)}",
        )
    return matrix


def _times(shape: tuple[int, ...]) -> str:
    return "x".join(str(n) for n in shape)


def _intrinsics(file: OpenCvFile, key: tuple[str, ...]) -> Floats:
    return _checked_intrinsics(file, ".".join(key), _shaped(file, key, (3, 3)))


def _checked_intrinsics(file: OpenCvFile, name: str, K: Floats) -> Floats:
    lower = np.abs([K[0, 1], K[1, 0], K[2, 0], K[2, 1], K[2, 2] - 1.0])
    good = K[0, 0] > 0 and K[1, 1] > 0 and lower.max() < 1e-9
    if not good or np.abs(K).max() > PIXELS_MAX:
        raise FileError(
            file.path,
            f"{name} must be [fx 0 cx; 0 fy cy; 0 0 1] in pixels with fx, fy above 0, "
            f"got {np.array2string(K.ravel(), precision=6, max_line_width=1000)}",
        )
    return K


def _distortion(file: OpenCvFile, key: tuple[str, ...]) -> Floats:
    D = file.matrix(*key)
    if max(D.shape) != D.size:
        raise FileError(
            file.path, f"{'.'.join(key)} must be a row or column, got {_times(D.shape)}"
        )
    return _checked_distortion(file, ".".join(key), D.ravel())


def _checked_distortion(file: OpenCvFile, name: str, D: Floats) -> Floats:
    if len(D) not in DISTORTION_LENGTHS:
        counts = ", ".join(str(n) for n in DISTORTION_LENGTHS if n)
        raise FileError(
            file.path, f"{name} must be a row or column of {counts} coefficients, got {len(D)}"
        )
    if len(D) and np.abs(D).max() > DISTORTION_MAX:
        raise FileError(
            file.path,
            f"{name} has the coefficient {D[np.abs(D).argmax()]:.3g}: no lens is like that",
        )
    return D


def _rotation(file: OpenCvFile, key: tuple[str, ...]) -> Floats:
    return checked_rotation(file, ".".join(key), _shaped(file, key, (3, 3)))


def checked_rotation(file: OpenCvFile, name: str, R: Floats) -> Floats:
    """The matrix, made an exact rotation where it was rounded. Raises FileError."""
    fault = float(np.abs(R @ R.T - np.eye(3)).max())
    if fault > ROTATION_TOLERANCE or np.linalg.det(R) < 0:
        raise FileError(
            file.path,
            f"{name} is not a rotation (R R^T differs from 1 by {fault:.2g}, "
            f"det R = {np.linalg.det(R):.3g})",
        )
    if fault < 1e-9:
        return R
    U, _, Vt = np.linalg.svd(R)
    return np.asarray(U @ Vt)


def _translation(file: OpenCvFile) -> Floats:
    T = file.matrix("T")
    if T.size != 3:
        raise FileError(file.path, f"T must be 3x1, got {_times(T.shape)}")
    return T.ravel()


def _size(file: OpenCvFile) -> Size | None:
    keys = ("image_width", "image_height")
    if not all(file.has(key) for key in keys):
        return None
    return _checked_size(file, [file.number(key) for key in keys])


def _checked_size(file: OpenCvFile, sides: list[float]) -> Size:
    if not all(1 <= n <= SIDE_MAX and n == int(n) for n in sides):
        raise FileError(
            file.path,
            f"image_width and image_height must be whole numbers of 1 to {SIDE_MAX}, "
            f"got {sides[0]:g} and {sides[1]:g}",
        )
    return int(sides[0]), int(sides[1])
