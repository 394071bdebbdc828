"""Solution of a stereo calibration: each camera alone, the numbering of boards, then the pair."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.boards import Board, Corners, turned
from pjpdaf.calibration import rectify
from pjpdaf.calibration_report import CalibrationReport, PairReport
from pjpdaf.camera import Camera, StereoRig
from pjpdaf.errors import BenchError
from pjpdaf.sources import VIEWS

# Lens models: number of coefficients -> flags. The 12 and 14 need many pictures to make sense.
LENS_FLAGS = {
    4: cv2.CALIB_FIX_K3,
    5: 0,
    8: cv2.CALIB_RATIONAL_MODEL,
    12: cv2.CALIB_RATIONAL_MODEL | cv2.CALIB_THIN_PRISM_MODEL,
    14: cv2.CALIB_RATIONAL_MODEL | cv2.CALIB_THIN_PRISM_MODEL | cv2.CALIB_TILTED_MODEL,
}
PAIRS_MIN = 4  # fewer board poses leave focal length and lens undetermined
OUTLIER_FACTOR = 3.0  # a picture this many times worse than the median ...
OUTLIER_FLOOR_PX = 0.5  # ... and worse than this is left out: moved, blurred, or mis-numbered
OUTLIER_ROUNDS = 5
SAME_POSE_DEG = 5.0  # how far one picture's estimate of the rig's rotation may be off
STOP = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 100, 1e-9)


@dataclass(frozen=True, eq=False)
class BoardPair:
    """Corners of a usable pair of pictures; index into the list of all pairs.

    turned: the right board was numbered from the other end.
    """

    index: int
    left: Corners
    right: Corners
    turned: bool = False

    def common(self) -> tuple[np.ndarray, Floats, Floats]:
        """Ids of the corners that both views have, and their pixels left and right."""
        ids, i, j = np.intersect1d(self.left.ids, self.right.ids, return_indices=True)
        return ids, self.left.pixels[i], self.right.pixels[j]


@dataclass(frozen=True, eq=False)
class Lens:
    """A camera calibrated alone: rotations (n, 3, 3) of the board in each picture, errors (n,)."""

    rms_px: float
    K: Floats
    distortion: Floats
    sd: Floats
    rotations: Floats
    errors_px: Floats


def solve(
    board: Board,
    pairs: list[BoardPair],
    reports: list[PairReport],
    size: tuple[int, int],
    coefficients: int,
) -> CalibrationReport:
    """Calibrate cameras and rig; pairs that fit badly are left out and all is done again.

    pairs: those that show the board; reports: of all pairs, brought up to date here; size: width
    and height [px]; coefficients: of the lens model.
    Raises BenchError where too few pairs are left.
    """
    for last in [False] * OUTLIER_ROUNDS + [True]:
        lenses = (
            _lens(board, [pair.left for pair in pairs], size, coefficients),
            _lens(board, [pair.right for pair in pairs], size, coefficients),
        )
        ordered = _same_numbering(board, pairs, *lenses)
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
            reports[pairs[i].index] = dataclasses.replace(
                reports[pairs[i].index],
                used=False,
                reason=f"reprojection outlier: {worst[i, view]:.2f} px in {VIEWS[view]}, "
                f"limit {limit[view]:.2f} px",
            )
        pairs = [pair for i, pair in enumerate(pairs) if not bad[i]]
        check_enough(pairs, reports)
    for pair, (error_left, error_right) in zip(ordered, errors, strict=True):
        reports[pair.index] = dataclasses.replace(
            reports[pair.index],
            turned=pair.turned,
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


def _lens(board: Board, pictures: list[Corners], size: tuple[int, int], coefficients: int) -> Lens:
    points = [board.corners_m[c.ids].astype(np.float32) for c in pictures]
    pixels = [c.pixels.astype(np.float32) for c in pictures]
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
    return Lens(
        float(rms),
        np.asarray(K, dtype=np.float64),
        np.ravel(D)[:coefficients].astype(np.float64),
        np.ravel(sd)[: 4 + coefficients].astype(np.float64),
        np.array(matrices),
        np.ravel(errors).astype(np.float64),
    )


def _same_numbering(
    board: Board, pairs: list[BoardPair], left: Lens, right: Lens
) -> list[BoardPair]:
    """Pairs whose corners are numbered from the same end in both views.

    Each picture pair gives the rig's rotation twice, for the right board as numbered and turned.
    The true rotation is that on which most pairs agree with either of their two.
    """
    if board.kind == "charuco":
        return pairs
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
        dataclasses.replace(pair, right=turned(board, pair.right), turned=True) if flip else pair
        for pair, flip in zip(pairs, chosen, strict=True)
    ]


def _angle_deg(A: Floats, B: Floats) -> Floats:
    """Angle of the rotation between A and B (..., 3, 3)."""
    trace = np.einsum("...ij,...ij->...", A, B)
    return np.asarray(np.degrees(np.arccos(np.clip((trace - 1) / 2, -1, 1))))


def _stereo(
    board: Board, pairs: list[BoardPair], lenses: tuple[Lens, Lens], size: tuple[int, int]
) -> tuple[float, Floats, Floats, Floats]:
    """Rig from pairs, lenses fixed: rms [px], R (3, 3), T (3,) [m], errors (n, 2) [px]."""
    common = [pair.common() for pair in pairs]
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


def _epipolar(rig: StereoRig, pairs: list[BoardPair]) -> float:
    """Mean distance between the rectified rows (or columns) of corresponding corners [px]."""
    R1, R2, P1, P2, *_ = rectify(rig)
    across = 0 if abs(P2[1, 3]) > abs(P2[0, 3]) else 1  # cameras above each other: columns
    distances = []
    for pair in pairs:
        _, left, right = pair.common()
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


def check_enough(pairs: list[BoardPair], reports: list[PairReport]) -> None:
    """Raise BenchError, with the reasons in the reports, for fewer than PAIRS_MIN pairs."""
    if len(pairs) >= PAIRS_MIN:
        return
    reasons = [f"{Path(r.left).name}: {r.reason}" for r in reports if r.reason]
    more = f" (and {len(reasons) - 3} more)" if len(reasons) > 3 else ""
    why = f" {'; '.join(reasons[:3])}{more}." if reasons else ""
    raise BenchError(
        f"A calibration needs at least {PAIRS_MIN} pairs that show the board in both views, got "
        f"{len(pairs)} of {len(reports)}.{why} "
        "Check columns and rows (inner corners), light, focus."
    )
