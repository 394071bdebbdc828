"""The cameras of a sequence: plausible, and the same in rig.json and in the calibration files."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import cv2
import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.calibration import EXTRINSICS, INTRINSICS, read_rig, rectify
from pjpdaf.camera import DISTORTION_LENGTHS, Camera, StereoRig
from sim.dataset.check.fault import Fault, FaultLog
from sim.dataset.files.layout import CALIBRATION, ERROR_FREE, RIG
from sim.dataset.stored_sequence import StoredSequence
from sim.lens import check
from sim.scene.world import CAMERAS

SAME = 1e-7  # of numbers that were written with all their digits [px, m, 1]
_COEFFICIENTS = max(DISTORTION_LENGTHS)


def usable(rig: StereoRig) -> bool:
    """Whether rays can be cast through these cameras."""
    left, right = rig.cameras
    return (
        not any(text for camera in rig.cameras for text in _implausible(camera))
        and (left.width_px, left.height_px) == (right.width_px, right.height_px)
        and float(np.linalg.norm(rig.T)) > SAME
    )


def check_rig(sequence: StoredSequence) -> Iterator[Fault]:
    """Check the cameras of rig.json. Raises FileError where they cannot be read."""
    path = f"{sequence.name}/{RIG}"
    for key, rig in (("cameras", sequence.rig), ("calibration", sequence.calibration)):
        for name, camera in zip(CAMERAS, rig.cameras, strict=True):
            for text in _implausible(camera):
                yield Fault(path, f"{key}.{name}: {text}")
        sizes = {(camera.width_px, camera.height_px) for camera in rig.cameras}
        if len(sizes) > 1:
            yield Fault(path, f"{key}: the two cameras' pictures are of different sizes")
        if rig.T[0] >= 0:
            yield Fault(path, f"{key}: the right camera is not right of the left one")


def check_calibration(sequence: StoredSequence, log: FaultLog) -> None:
    """Compare calib/ of the sequence and of the data set with rig.json."""
    path = f"{sequence.name}/{RIG}"
    folders = [f"{sequence.name}/{CALIBRATION}"]
    if (log.root / CALIBRATION).is_dir():
        folders.append(CALIBRATION)
    for folder in folders:
        for where, rig, key in (
            (folder, sequence.calibration, f"{path} calibration"),
            (f"{folder}/{ERROR_FREE}", sequence.rig, f"{path} cameras"),
        ):
            stored = log.read(partial(read_rig, log.root / where))
            if stored is not None:
                log.add("calibration", _calibration_faults(log, where, stored, rig, key))


def _implausible(camera: Camera) -> Iterator[str]:
    R, K = camera.R_cw, camera.K
    if np.abs(R @ R.T - np.eye(3)).max() > SAME or np.linalg.det(R) < 0:
        yield "R_cw is not a rotation"
    lower = np.abs([K[0, 1], K[1, 0], K[2, 0], K[2, 1], K[2, 2] - 1.0])
    if not (K[0, 0] > 0 and K[1, 1] > 0 and lower.max() < SAME):
        yield "K is not [fx 0 cx; 0 fy cy; 0 0 1] with fx, fy above 0"
        return
    try:
        check(camera)
    except ValueError as error:
        yield str(error)


def _calibration_faults(
    log: FaultLog, folder: str, stored: StereoRig, rig: StereoRig, other: str
) -> Iterator[Fault]:
    inner, outer = f"{folder}/{INTRINSICS}", f"{folder}/{EXTRINSICS}"
    pairs = zip(stored.cameras, rig.cameras, strict=True)
    for number, (camera, expected) in enumerate(pairs, start=1):
        if (camera.width_px, camera.height_px) != (expected.width_px, expected.height_px):
            yield Fault(inner, f"image_width, image_height differ from {other}")
        yield from _difference(inner, f"M{number}", camera.K, expected.K, other, "px")
        D, expected_D = (
            np.pad(c.distortion, (0, _COEFFICIENTS - len(c.distortion))) for c in (camera, expected)
        )
        yield from _difference(inner, f"D{number}", D, expected_D, other, "")
    yield from _difference(outer, "R", stored.R, rig.R, other, "")
    yield from _difference(outer, "T", stored.T, rig.T, other, "m")
    derived = rectify(stored)[:5]
    for key, expected_matrix in zip(("R1", "R2", "P1", "P2", "Q"), derived, strict=True):
        matrix = _matrix(f"{log.root / outer}", key)
        if matrix is None or matrix.shape != expected_matrix.shape:
            shape = "x".join(map(str, expected_matrix.shape))
            yield Fault(outer, f"{key}: missing, or no {shape} matrix")
            continue
        source = f"cv2.stereoRectify of M, D, R, T of {folder}"
        yield from _difference(outer, key, matrix, expected_matrix, source, "")


def _difference(
    file: str, key: str, values: Floats, expected: Floats, other: str, unit: str
) -> Iterator[Fault]:
    off = float(np.abs(values - expected).max(initial=0.0))
    # The yardstick of P and Q is their focal length, of T a metre.
    if not off <= SAME * max(1.0, float(np.abs(expected).max(initial=0.0))):
        yield Fault(file, f"{key} differs from {other} by {off:.6g} {unit}".rstrip())


def _matrix(path: str, key: str) -> Floats | None:
    storage = cv2.FileStorage(path, cv2.FILE_STORAGE_READ)
    try:
        value = storage.getNode(key).mat()
    except (cv2.error, SystemError):
        return None
    finally:
        storage.release()
    return None if value is None else np.asarray(value, np.float64)
