"""Stereo calibration from pictures of a board: each camera first, then the pair."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from pjpdaf.arrays import Floats, readonly
from pjpdaf.boards import CHARUCO_CORNERS_MIN, Board, Corners, draw_corners, find_corners, turned
from pjpdaf.calibration import rectify, write_rig
from pjpdaf.camera import Camera, StereoRig
from pjpdaf.errors import BenchError
from pjpdaf.sources import VIEWS, PicturePair, Warn, picture_pairs

# Lens models: number of coefficients -> flags. The 12 and 14 need many pictures to make sense.
LENS_FLAGS = {
    4: cv2.CALIB_FIX_K3,
    5: 0,
    8: cv2.CALIB_RATIONAL_MODEL,
    12: cv2.CALIB_RATIONAL_MODEL | cv2.CALIB_THIN_PRISM_MODEL,
    14: cv2.CALIB_RATIONAL_MODEL | cv2.CALIB_THIN_PRISM_MODEL | cv2.CALIB_TILTED_MODEL,
}
PAIRS_MIN = 4  # fewer board poses leave focal length and lens undetermined
OUTLIER_FACTOR = 3.0  # a picture this many times worse than the median one ...
OUTLIER_FLOOR_PX = 0.5  # ... and worse than this is left out: moved, blurred, or mis-numbered
OUTLIER_ROUNDS = 5
SAME_POSE_DEG = 5.0  # how far one picture's estimate of the rig's rotation may be off
STOP = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 100, 1e-9)


@dataclass(frozen=True)
class PairReport:
    """What became of one pair of pictures.

    used, and if not the reason; turned: the right board was numbered from the other end; errors:
    root mean square reprojection error of the final rig in each view [px], NaN if not used.
    """

    left: str
    right: str
    used: bool
    reason: str = ""
    turned: bool = False
    error_left_px: float = float("nan")
    error_right_px: float = float("nan")


@dataclass(frozen=True, eq=False)
class CalibrationReport:
    """A calibration and how good it is.

    rig: left camera at the origin; pairs: every pair, in order; rms_left_px, rms_right_px: each
    camera alone; rms_stereo_px: the final rig; epipolar_px: mean |y_left - y_right| of the corners
    after rectification. sd_left, sd_right (4 + n,): one standard deviation of fx fy cx cy [px] and
    of the lens's coefficients; files: what was written.
    """

    board: Board
    rig: StereoRig
    pairs: tuple[PairReport, ...]
    rms_left_px: float
    rms_right_px: float
    rms_stereo_px: float
    epipolar_px: float
    sd_left: Floats
    sd_right: Floats
    files: tuple[Path, ...] = ()

    def __post_init__(self) -> None:
        for name in ("sd_left", "sd_right"):
            value = readonly(getattr(self, name), (None,), f"CalibrationReport.{name}")
            object.__setattr__(self, name, value)

    @property
    def used(self) -> int:
        """Number of pairs that the calibration rests on."""
        return sum(pair.used for pair in self.pairs)

    @property
    def baseline_m(self) -> float:
        """Distance between the cameras [m]."""
        return float(np.linalg.norm(self.rig.T))


@dataclass(frozen=True, eq=False)
class _Seen:
    """Corners of one usable pair; index into the list of all pairs."""

    index: int
    left: Corners
    right: Corners
    turned: bool = False


@dataclass(frozen=True, eq=False)
class _Lens:
    """One camera calibrated alone: rotations (n, 3, 3) of the board in each picture."""

    rms_px: float
    K: Floats
    distortion: Floats
    sd: Floats
    rotations: Floats
    errors_px: Floats


def calibrate(
    left: Path | str,
    right: Path | str,
    board: Board,
    out: Path | str | None = None,
    coefficients: int = 5,
    warn: Warn | None = None,
) -> CalibrationReport:
    """Calibrates from two folders (or videos) of board pictures taken at the same moments.

    out: folder for intrinsics.yml, extrinsics.yml, pictures of the corners found, and one rectified
    pair with horizontal lines; coefficients: of the lens model, one of 4, 5, 8, 12, 14.

    Raises BenchError where the sources do not fit or too few pairs show the board.
    """
    folder = Path(out) if out is not None else None
    return calibrate_pairs(picture_pairs(left, right, warn), board, folder, coefficients)


def calibrate_pairs(
    pairs: Iterable[PicturePair], board: Board, out: Path | None = None, coefficients: int = 5
) -> CalibrationReport:
    """`calibrate` from pairs of pictures, read one at a time."""
    if coefficients not in LENS_FLAGS:
        raise BenchError(
            f"The lens model must have one of {', '.join(map(str, LENS_FLAGS))} coefficients, "
            f"got {coefficients}."
        )
    files: list[Path] = []
    reports: list[PairReport] = []
    seen: list[_Seen] = []
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
            seen.append(_Seen(len(reports), corners[0], corners[1]))
            if example is None and pair.pictures[0] is not None and pair.pictures[1] is not None:
                example = pair.pictures[0], pair.pictures[1]
        reports.append(PairReport(*pair.names, used=not reason, reason=reason))
    _enough(seen, reports)
    assert size is not None
    report = _solve(board, seen, reports, size, coefficients)
    if out is not None:
        files = [*write_rig(report.rig, out), *files]
        if example is not None:
            files.append(out / "rectified.png")
            _write(files[-1], rectified_pair(report.rig, *example))
    return dataclasses.replace(report, files=tuple(files))


def _solve(
    board: Board,
    seen: list[_Seen],
    reports: list[PairReport],
    size: tuple[int, int],
    coefficients: int,
) -> CalibrationReport:
    """Cameras, numbering, pair; pictures that fit badly are left out and all is done again."""
    for last in [False] * OUTLIER_ROUNDS + [True]:
        lenses = (
            _camera(board, [s.left for s in seen], size, coefficients),
            _camera(board, [s.right for s in seen], size, coefficients),
        )
        ordered = _same_numbering(board, seen, *lenses)
        rms, R, T, errors = _stereo(board, ordered, lenses, size)
        # Each camera alone finds a blurred picture; only the pair finds a board that moved between.
        worst = np.maximum(errors, np.column_stack([lens.errors_px for lens in lenses]))
        limit = np.maximum(OUTLIER_FACTOR * np.median(worst, axis=0), OUTLIER_FLOOR_PX)
        bad = (worst > limit).any(axis=1)
        if last or not bad.any():
            break
        # The worst half only: one very bad picture spoils the errors of the good ones.
        score = (worst / limit).max(axis=1)
        bad &= score >= np.sort(score[bad])[bad.sum() // 2]
        for i in np.flatnonzero(bad):
            view = int(np.argmax(worst[i] / limit))
            reports[seen[i].index] = dataclasses.replace(
                reports[seen[i].index],
                used=False,
                reason=f"reprojection outlier: {worst[i, view]:.2f} px in {VIEWS[view]}, "
                f"limit {limit[view]:.2f} px",
            )
        seen = [s for i, s in enumerate(seen) if not bad[i]]
        _enough(seen, reports)
    for s, (error_left, error_right) in zip(ordered, errors, strict=True):
        reports[s.index] = dataclasses.replace(
            reports[s.index],
            turned=s.turned,
            error_left_px=float(error_left),
            error_right_px=float(error_right),
        )
    cameras = [
        Camera(lens.K, rotation, translation, *size, lens.distortion)
        for lens, rotation, translation in zip(
            lenses, (np.eye(3), R), (np.zeros(3), T), strict=True
        )
    ]
    rig = StereoRig(*cameras)
    return CalibrationReport(
        board,
        rig,
        tuple(reports),
        lenses[0].rms_px,
        lenses[1].rms_px,
        rms,
        _epipolar(rig, ordered),
        lenses[0].sd,
        lenses[1].sd,
    )


def _camera(board: Board, seen: list[Corners], size: tuple[int, int], coefficients: int) -> _Lens:
    points = [board.corners_m[c.ids].astype(np.float32) for c in seen]
    pixels = [c.pixels.astype(np.float32) for c in seen]
    try:
        rms, K, D, rotations, _, sd, _, errors = cv2.calibrateCameraExtended(
            points, pixels, size, None, None, flags=LENS_FLAGS[coefficients], criteria=STOP
        )
    except cv2.error as fault:
        raise BenchError(
            f"The calibration of a camera failed ({fault.err}): take pictures of the board at "
            "different tilts and distances."
        ) from None
    matrices = [cv2.Rodrigues(np.asarray(r, dtype=np.float64).ravel())[0] for r in rotations]
    return _Lens(
        float(rms),
        np.asarray(K, dtype=np.float64),
        np.ravel(D)[:coefficients].astype(np.float64),
        np.ravel(sd)[: 4 + coefficients].astype(np.float64),
        np.array(matrices),
        np.ravel(errors).astype(np.float64),
    )


def _same_numbering(board: Board, seen: list[_Seen], left: _Lens, right: _Lens) -> list[_Seen]:
    """Pairs whose corners are numbered from the same end in both views.

    Each picture pair gives the rig's rotation twice, for the right board as numbered and turned.
    The true rotation is the one that most pairs agree on with one of their two.
    """
    if board.kind == "charuco":
        return seen
    half_turn = np.diag([-1.0, -1.0, 1.0])  # turning the numbering rotates the board in its plane
    backwards = np.swapaxes(left.rotations, 1, 2)
    straight = right.rotations @ backwards
    flipped = right.rotations @ half_turn @ backwards
    both = np.stack([straight, flipped], axis=1)  # (n, 2, 3, 3)
    candidates = both.reshape(-1, 3, 3)
    angles = _angle_deg(candidates[:, None, None], both[None])  # (2 n, n, 2)
    cost = np.minimum(angles.min(axis=2), SAME_POSE_DEG).sum(axis=1)
    chosen = angles[int(np.argmin(cost))].argmin(axis=1)
    return [
        dataclasses.replace(s, right=turned(board, s.right), turned=True) if flip else s
        for s, flip in zip(seen, chosen, strict=True)
    ]


def _angle_deg(A: Floats, B: Floats) -> Floats:
    """Angle of the rotation between A and B (..., 3, 3)."""
    trace = np.einsum("...ij,...ij->...", A, B)
    return np.asarray(np.degrees(np.arccos(np.clip((trace - 1) / 2, -1, 1))))


def _common(seen: _Seen) -> tuple[np.ndarray, Floats, Floats]:
    """Ids of the corners that both views have, and their pixels."""
    ids, i, j = np.intersect1d(seen.left.ids, seen.right.ids, return_indices=True)
    return ids, seen.left.pixels[i], seen.right.pixels[j]


def _stereo(
    board: Board, seen: list[_Seen], lenses: tuple[_Lens, _Lens], size: tuple[int, int]
) -> tuple[float, Floats, Floats, Floats]:
    """Rig from pairs, lenses fixed: rms [px], R (3, 3), T (3,) [m], errors (n, 2) [px]."""
    common = [_common(s) for s in seen]
    rms, _, _, _, _, R, T, _, _, _, _, errors = cv2.stereoCalibrateExtended(
        [board.corners_m[ids].astype(np.float32) for ids, _, _ in common],
        [left.astype(np.float32) for _, left, _ in common],
        [right.astype(np.float32) for _, _, right in common],
        lenses[0].K.copy(),
        lenses[0].distortion.copy(),
        lenses[1].K.copy(),
        lenses[1].distortion.copy(),
        size,
        np.eye(3),
        np.zeros((3, 1)),
        flags=cv2.CALIB_FIX_INTRINSIC,
        criteria=STOP,
    )
    return float(rms), np.asarray(R), np.ravel(T), np.asarray(errors).reshape(-1, 2)


def _epipolar(rig: StereoRig, seen: list[_Seen]) -> float:
    """Mean distance between the rectified rows (or columns) of corresponding corners [px]."""
    R1, R2, P1, P2, *_ = rectify(rig)
    across = 0 if abs(P2[1, 3]) > abs(P2[0, 3]) else 1  # cameras above each other: columns
    distances = []
    for s in seen:
        _, left, right = _common(s)
        rows = [
            cv2.undistortPoints(
                pixels.reshape(-1, 1, 2), np.array(camera.K), np.array(camera.distortion), R=R, P=P
            ).reshape(-1, 2)[:, across]
            for camera, pixels, R, P in zip(
                rig.cameras, (left, right), (R1, R2), (P1, P2), strict=True
            )
        ]
        distances.append(np.abs(rows[0] - rows[1]))
    return float(np.concatenate(distances).mean())


def rectified_pair(rig: StereoRig, left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Both pictures rectified, side by side (h, 2 w, 3), with horizontal lines every 32 px."""
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
    """Why a pair cannot be used, '' if it can."""
    for view, picture in zip(VIEWS, pair.pictures, strict=True):
        if picture is None:
            return f"no readable picture in {view}"
    without = [view for view, c in zip(VIEWS, corners, strict=True) if c is None]
    if without:
        return f"no board found in {' and '.join(without)}"
    left, right = corners
    assert left is not None
    assert right is not None
    both = len(np.intersect1d(left.ids, right.ids))
    if board.kind == "charuco" and both < CHARUCO_CORNERS_MIN:
        return f"only {both} corners seen in both views, {CHARUCO_CORNERS_MIN} needed"
    return ""


def _enough(seen: list[_Seen], reports: list[PairReport]) -> None:
    if len(seen) >= PAIRS_MIN:
        return
    reasons = [f"{Path(r.left).name}: {r.reason}" for r in reports if r.reason]
    more = f" (and {len(reasons) - 3} more)" if len(reasons) > 3 else ""
    why = f" {'; '.join(reasons[:3])}{more}." if reasons else ""
    raise BenchError(
        f"A calibration needs at least {PAIRS_MIN} pairs that show the board in both views, got "
        f"{len(seen)} of {len(reports)}.{why} Check columns and rows (inner corners), light, focus."
    )


def _write_corners(
    out: Path, board: Board, pair: PicturePair, corners: list[Corners | None]
) -> list[Path]:
    files = []
    for view, picture, found in zip(VIEWS, pair.pictures, corners, strict=True):
        if picture is not None:
            files.append(out / "corners" / f"{pair.index:04d}_{view}.png")
            _write(files[-1], draw_corners(board, picture, found))
    return files


def _write(file: Path, picture: np.ndarray) -> None:
    file.parent.mkdir(parents=True, exist_ok=True)
    if not cv2.imwrite(str(file), picture):
        raise BenchError(f"{file}: cannot be written.")
