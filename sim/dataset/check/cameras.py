"""The cameras of a sequence: plausible, and the same in rig.json and in the calibration's files."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.calibration import EXTRINSICS, INTRINSICS, read_rig, rectify
from pjpdaf.camera import DISTORTION_LENGTHS, Camera, StereoRig
from pjpdaf.errors import BenchError
from sim.dataset.check.fault import Fault, fault_of
from sim.dataset.files.layout import CALIBRATION, ERROR_FREE, RIG
from sim.dataset.stored_sequence import StoredSequence
from sim.lens import check

_LENS = max(DISTORTION_LENGTHS)
SAME = 1e-7  # of numbers that were written with all their digits [px, m, 1]


def usable(rig: StereoRig) -> bool:
    """Whether rays can be cast through these cameras."""
    left, right = rig.cameras
    return (
        not any(what for camera in rig.cameras for what in _implausible(camera))
        and (left.width_px, left.height_px) == (right.width_px, right.height_px)
        and float(np.linalg.norm(rig.T)) > SAME
    )


def camera_faults(root: Path, sequence: StoredSequence) -> Iterator[Fault]:
    """Of rig.json, and of calib/ of the sequence and of the data set."""
    path = f"{sequence.name}/{RIG}"
    try:
        given, exact = sequence.calibration, sequence.rig
    except BenchError as error:
        yield fault_of(error, root)
        return
    for key, rig in (("cameras", exact), ("calibration", given)):
        for name, camera in zip(("left", "right"), rig.cameras, strict=True):
            for what in _implausible(camera):
                yield Fault(path, f"{key}.{name}: {what}")
        sizes = {(camera.width_px, camera.height_px) for camera in rig.cameras}
        if len(sizes) > 1:
            yield Fault(path, f"{key}: the two cameras' pictures are of different sizes")
        if rig.T[0] >= 0:
            yield Fault(path, f"{key}: the right camera is not right of the left one")
    shared = [CALIBRATION] if (root / CALIBRATION).is_dir() else []
    for folder in (f"{sequence.name}/{CALIBRATION}", *shared):
        yield from _calibration_faults(root, folder, given, f"{path} calibration")
        yield from _calibration_faults(root, f"{folder}/{ERROR_FREE}", exact, f"{path} cameras")


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


def _calibration_faults(root: Path, folder: str, rig: StereoRig, other: str) -> Iterator[Fault]:
    inner, outer = f"{folder}/{INTRINSICS}", f"{folder}/{EXTRINSICS}"
    try:
        file = read_rig(root / folder)
    except BenchError as error:
        yield fault_of(error, root)
        return
    pairs = zip(file.cameras, rig.cameras, strict=True)
    for number, (mine, its) in enumerate(pairs, start=1):
        if (mine.width_px, mine.height_px) != (its.width_px, its.height_px):
            yield Fault(inner, f"image_width, image_height differ from {other}")
        yield from _compared(inner, f"M{number}", mine.K, its.K, other, "px")
        mine_d, its_d = (np.pad(c.distortion, (0, _LENS - len(c.distortion))) for c in (mine, its))
        yield from _compared(inner, f"D{number}", mine_d, its_d, other, "")
    yield from _compared(outer, "R", file.R, rig.R, other, "")
    yield from _compared(outer, "T", file.T, rig.T, other, "m")
    derived = rectify(file)[:5]
    for key, matrix in zip(("R1", "R2", "P1", "P2", "Q"), derived, strict=True):
        stored = _matrix(root / outer, key)
        if stored is None or stored.shape != matrix.shape:
            yield Fault(outer, f"{key}: missing, or no {'x'.join(map(str, matrix.shape))} matrix")
            continue
        what = f"cv2.stereoRectify of M, D, R, T of {folder}"
        yield from _compared(outer, key, stored, matrix, what, "")


def _compared(
    file: str, key: str, mine: Floats, its: Floats, other: str, unit: str
) -> Iterator[Fault]:
    off = float(np.abs(mine - its).max(initial=0.0))
    # The yardstick of P and Q are their focal lengths, of T metres.
    if not off <= SAME * max(1.0, float(np.abs(its).max(initial=0.0))):
        yield Fault(file, f"{key} differs from {other} by {off:.6g} {unit}".rstrip())


def _matrix(path: Path, key: str) -> Floats | None:
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_READ)
    try:
        value = storage.getNode(key).mat()
    except (cv2.error, SystemError):
        return None
    finally:
        storage.release()
    return None if value is None else np.asarray(value, np.float64)
