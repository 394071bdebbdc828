"""Calibration files: intrinsics.yml and extrinsics.yml as OpenCV's stereo sample writes them."""

from __future__ import annotations

import math
from pathlib import Path

import cv2
import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.camera import DISTORTION_LENGTHS, Camera, StereoRig
from pjpdaf.errors import BenchError, FileError

INTRINSICS, EXTRINSICS = "intrinsics.yml", "extrinsics.yml"
ROTATION_TOLERANCE = 1e-3  # a matrix typed with four digits is still meant to be a rotation
BASELINE_MAX_M = 10.0  # above this the file is in millimetres, or in squares


def read_rig(
    intrinsics: Path | str,
    extrinsics: Path | str | None = None,
    size_px: tuple[int, int] | None = None,
    unit_m: float = 1.0,
) -> StereoRig:
    """Read a rig, in the left camera's frame (left R_cw = I, t_cw = 0), from OpenCV YAML (or XML).

    intrinsics: file with M1 D1 M2 D2, or the folder that holds both files under their usual names;
    extrinsics: file with R T (default: beside the first under its usual name, or, where that file
    has R itself, that file); size_px: width and height of the pictures, needed where the files
    have no image_width and image_height; unit_m: length of T's unit [m], 0.001 for millimetres.

    Raises FileError naming file and key.
    """
    first = Path(intrinsics)
    if first.is_dir():
        first, second = first / INTRINSICS, first / EXTRINSICS
    else:
        second = first.with_name(EXTRINSICS)
    inner = _Yaml(first)
    try:
        outer = inner
        if extrinsics is not None:
            outer = _Yaml(Path(extrinsics))
        elif not inner.has("R"):
            outer = _Yaml(second)
        K1, K2 = _intrinsics(inner, "M1"), _intrinsics(inner, "M2")
        D1, D2 = _distortion(inner, "D1"), _distortion(inner, "D2")
        R, T = _rotation(outer), _translation(outer, unit_m)
        width, height = _size(inner, size_px)
    finally:
        inner.close()
    left = Camera(K1, np.eye(3), np.zeros(3), width, height, D1)
    right = Camera(K2, R, T, width, height, D2)
    return StereoRig(left, right)


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


class _Yaml:
    """OpenCV's FileStorage opened for reading; each fault is a FileError."""

    def __init__(self, path: Path) -> None:
        self.path = path
        if not path.is_file():
            raise FileError(path, "no such calibration file")
        level = cv2.utils.logging.getLogLevel()
        cv2.utils.logging.setLogLevel(0)  # OpenCV prints its own account of the faults raised here
        try:
            self._storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_READ)
            opened = self._storage.isOpened()
            self._keys = set(self._storage.root().keys()) if opened else set()
        except (cv2.error, SystemError, UnicodeDecodeError):
            opened = False
        finally:
            cv2.utils.logging.setLogLevel(level)
        if not opened:
            raise FileError(
                path, "not an OpenCV calibration file (YAML that begins with %YAML, or XML)"
            )

    def close(self) -> None:
        self._storage.release()

    def has(self, key: str) -> bool:
        return key in self._keys

    def matrix(self, key: str) -> Floats:
        """Return the matrix of a key. Raises FileError if it is not of finite numbers."""
        if not self.has(key):
            there = f". It has {', '.join(sorted(self._keys))}" if self._keys else ""
            raise FileError(self.path, f"key {key} is missing{there}")
        try:
            value = self._storage.getNode(key).mat()
        except (cv2.error, SystemError):
            value = None
        if value is None:
            raise FileError(self.path, f"{key} is not a matrix (!!opencv-matrix)")
        matrix = np.asarray(value, dtype=np.float64)
        if not np.isfinite(matrix).all():
            raise FileError(self.path, f"{key} has values that are not finite numbers")
        return matrix

    def number(self, key: str) -> float:
        node = self._storage.getNode(key)
        if not (node.isInt() or node.isReal()):
            raise FileError(self.path, f"{key} is not a number")
        return float(node.real())


def _shaped(file: _Yaml, key: str, shape: tuple[int, int]) -> Floats:
    matrix = file.matrix(key)
    if matrix.shape != shape:
        raise FileError(
            file.path,
            f"{key} must be {shape[0]}x{shape[1]}, got {'x'.join(str(n) for n in matrix.shape)}",
        )
    return matrix


def _intrinsics(file: _Yaml, key: str) -> Floats:
    K = _shaped(file, key, (3, 3))
    lower = np.abs([K[0, 1], K[1, 0], K[2, 0], K[2, 1], K[2, 2] - 1.0])
    if not (K[0, 0] > 0 and K[1, 1] > 0 and lower.max() < 1e-9):
        raise FileError(
            file.path,
            f"{key} must be [fx 0 cx; 0 fy cy; 0 0 1] with fx, fy above 0, "
            f"got {np.array2string(K.ravel(), precision=6, max_line_width=1000)}",
        )
    return K


def _distortion(file: _Yaml, key: str) -> Floats:
    D = file.matrix(key)
    counts = [n for n in DISTORTION_LENGTHS if n]
    if D.size not in counts or max(D.shape) != D.size:
        raise FileError(
            file.path,
            f"{key} must be a row or column of {', '.join(map(str, counts))} "
            f"coefficients, got {'x'.join(str(n) for n in D.shape)}",
        )
    return D.ravel()


def _rotation(file: _Yaml) -> Floats:
    """R, made an exact rotation where it was rounded."""
    R = _shaped(file, "R", (3, 3))
    fault = float(np.abs(R @ R.T - np.eye(3)).max())
    if fault > ROTATION_TOLERANCE or np.linalg.det(R) < 0:
        raise FileError(
            file.path,
            f"R is not a rotation (R R^T differs from 1 by {fault:.2g}, "
            f"det R = {np.linalg.det(R):.3g})",
        )
    if fault < 1e-9:
        return R
    U, _, Vt = np.linalg.svd(R)
    return np.asarray(U @ Vt)


def _translation(file: _Yaml, unit_m: float) -> Floats:
    T = file.matrix("T")
    if T.size != 3:
        raise FileError(file.path, f"T must be 3x1, got {'x'.join(str(n) for n in T.shape)}")
    T = T.ravel() * unit_m
    length = float(np.linalg.norm(T))
    if length < 1e-6:
        raise FileError(file.path, "T is zero; two cameras at the same place see no depth")
    if length > BASELINE_MAX_M:
        raise FileError(
            file.path,
            f"T is {length:g} m long; metres are expected: calibrate with the square "
            "size in metres, or give the unit (0.001 m for millimetres)",
        )
    return T


def _size(file: _Yaml, size_px: tuple[int, int] | None) -> tuple[int, int]:
    keys = ("image_width", "image_height")
    if not all(file.has(key) for key in keys):
        if size_px is None:
            raise FileError(
                file.path,
                "keys image_width and image_height are missing, so the size of the "
                "pictures must be given",
            )
        return size_px
    numbers = [file.number(key) for key in keys]
    if not all(math.isfinite(n) and n >= 1 and n == int(n) for n in numbers):
        raise FileError(
            file.path,
            f"image_width and image_height must be whole numbers above 0, "
            f"got {numbers[0]:g} and {numbers[1]:g}",
        )
    size = int(numbers[0]), int(numbers[1])
    if size_px is not None and tuple(size_px) != size:
        raise FileError(
            file.path,
            f"calibrated at {size[0]}x{size[1]} px (image_width, image_height), but "
            f"the pictures are {size_px[0]}x{size_px[1]}",
        )
    return size
