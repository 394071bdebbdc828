"""Stereo calibration from pictures of a board."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from pathlib import Path

import cv2
import numpy as np

from pjpdaf.boards import (
    CHARUCO_CORNERS_MIN,
    Board,
    Corners,
    draw_corners,
    find_corners,
    markers_seen,
)
from pjpdaf.calibration import rectify, write_rig
from pjpdaf.calibration_report import CalibrationReport, PairReport
from pjpdaf.camera import StereoRig
from pjpdaf.errors import BenchError
from pjpdaf.sources import VIEWS, PicturePair
from pjpdaf.stereo_solver import LENS_FLAGS, BoardPair, check_enough, solve


def calibrate(
    pairs: Iterable[PicturePair], board: Board, out: Path | None = None, coefficients: int = 5
) -> CalibrationReport:
    """Calibrate from pairs of pictures taken at the same moments, read one at a time.

    out: folder for intrinsics.yml, extrinsics.yml, pictures of the corners, and one rectified pair
    with horizontal lines; coefficients: of the lens model, one of 4, 5, 8, 12, 14.
    Raises BenchError where the sources do not fit or too few pairs show the board.
    """
    if coefficients not in LENS_FLAGS:
        raise BenchError(
            f"The lens model must have one of {', '.join(map(str, LENS_FLAGS))} coefficients, "
            f"got {coefficients}."
        )
    files: list[Path] = []
    reports: list[PairReport] = []
    usable: list[BoardPair] = []
    example: tuple[np.ndarray, np.ndarray] | None = None
    size: tuple[int, int] | None = None
    for pair in pairs:
        size = _same_size(pair, size)
        corners = [None if p is None else find_corners(board, p) for p in pair.pictures]
        if out is not None:
            files += _write_corners(out, board, pair, corners)
        reason = _unusable(board, pair, corners)
        if not reason:
            assert corners[0] is not None
            assert corners[1] is not None
            usable.append(BoardPair(len(reports), corners[0], corners[1]))
            if example is None and pair.pictures[0] is not None and pair.pictures[1] is not None:
                example = pair.pictures[0], pair.pictures[1]
        reports.append(PairReport(*pair.names, used=not reason, reason=reason))
    check_enough(usable, reports)
    assert size is not None
    report = solve(board, usable, reports, size, coefficients)
    if out is not None:
        files = [*write_rig(report.rig, out), *files]
        if example is not None:
            files.append(out / "rectified.png")
            _write(files[-1], rectified_pair(report.rig, *example))
    return dataclasses.replace(report, files=tuple(files))


def rectified_pair(rig: StereoRig, left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Draw both pictures rectified, side by side (h, 2 w, 3), with horizontal lines every 32 px."""
    R1, R2, P1, P2, *_ = rectify(rig)
    size = (rig.left.width_px, rig.left.height_px)
    halves = []
    for camera, picture, R, P in zip(rig.cameras, (left, right), (R1, R2), (P1, P2), strict=True):
        maps = cv2.initUndistortRectifyMap(
            np.array(camera.K), np.array(camera.distortion), R, P[:, :3], size, cv2.CV_16SC2
        )
        halves.append(cv2.remap(picture, *maps, cv2.INTER_LINEAR))
    both: np.ndarray = np.hstack(halves)
    for y in range(16, size[1], 32):
        cv2.line(both, (0, y), (both.shape[1] - 1, y), (0, 200, 0), 1)
    return both


def _same_size(pair: PicturePair, size: tuple[int, int] | None) -> tuple[int, int] | None:
    for name, picture in zip(pair.names, pair.pictures, strict=True):
        if picture is None:
            continue
        here = (picture.shape[1], picture.shape[0])
        if size is not None and here != size:
            raise BenchError(
                f"{name}: the picture is {here[0]}x{here[1]} px, the others {size[0]}x{size[1]}; "
                "all pictures of a calibration must have one size."
            )
        size = here
    return size


def _unusable(board: Board, pair: PicturePair, corners: list[Corners | None]) -> str:
    """Reason why a pair cannot be used, '' if it can."""
    for view, picture in zip(VIEWS, pair.pictures, strict=True):
        if picture is None:
            return f"no readable picture in {view}"
    without = [view for view, c in zip(VIEWS, corners, strict=True) if c is None]
    if without:
        seen = [
            markers_seen(board, picture)
            for picture, c in zip(pair.pictures, corners, strict=True)
            if c is None and picture is not None
        ]
        reason = f"no board found in {' and '.join(without)}"
        if any(seen):
            reason += (
                f": {' and '.join(map(str, seen))} markers of {board.dictionary} seen, but no "
                f"corners between them; is it a board of {board.columns + 1} x {board.rows + 1} "
                "squares?"
            )
        return reason
    left, right = corners
    assert left is not None
    assert right is not None
    both = len(np.intersect1d(left.ids, right.ids))
    if board.kind == "charuco" and both < CHARUCO_CORNERS_MIN:
        return f"only {both} corners seen in both views, {CHARUCO_CORNERS_MIN} needed"
    return ""


def _write_corners(
    out: Path, board: Board, pair: PicturePair, corners: list[Corners | None]
) -> list[Path]:
    files = []
    for view, picture, marks in zip(VIEWS, pair.pictures, corners, strict=True):
        if picture is not None:
            files.append(out / "corners" / f"{pair.index:04d}_{view}.png")
            _write(files[-1], draw_corners(board, picture, marks))
    return files


def _write(file: Path, picture: np.ndarray) -> None:
    file.parent.mkdir(parents=True, exist_ok=True)
    if not cv2.imwrite(str(file), picture):
        raise BenchError(f"{file}: cannot be written.")
