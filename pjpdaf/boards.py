"""Calibration boards: chessboard and ChArUco, and their corners in a picture."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import cv2
import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.errors import BenchError

BOARD_KINDS = ("chessboard", "charuco")
REFINE_MIN_PX, REFINE_MAX_PX = 2, 10  # half the window of the sub-pixel search
CHARUCO_CORNERS_MIN = 6  # fewer do not fix a pose and a lens
# Tried in order until the board is detected. Normalising the picture comes late: where most of it
# is dark it turns noise into contrast, and 23 of 32 rendered boards on black were missed.
_CHESSBOARD_SEARCHES = (
    (cv2.findChessboardCornersSB, cv2.CALIB_CB_ACCURACY),
    (cv2.findChessboardCorners, cv2.CALIB_CB_ADAPTIVE_THRESH | cv2.CALIB_CB_NORMALIZE_IMAGE),
    (
        cv2.findChessboardCornersSB,
        cv2.CALIB_CB_NORMALIZE_IMAGE | cv2.CALIB_CB_ACCURACY | cv2.CALIB_CB_EXHAUSTIVE,
    ),
)


@dataclass(frozen=True)
class Board:
    """A flat board of squares.

    columns, rows: inner corners (where four squares meet), so a board of 10 x 7 squares is 9 x 6;
    square_m: side of a square [m]. ChArUco only: marker_m, side of a marker [m]; dictionary,
    OpenCV's name of its markers.
    """

    kind: Literal["chessboard", "charuco"]
    columns: int
    rows: int
    square_m: float
    marker_m: float = 0.0
    dictionary: str = "DICT_4X4_50"

    def __post_init__(self) -> None:
        if self.kind not in BOARD_KINDS:
            raise BenchError(f"Board.kind must be one of {BOARD_KINDS}, got {self.kind!r}.")
        least = 3 if self.kind == "chessboard" else 2
        if min(self.columns, self.rows) < least:
            raise BenchError(
                f"A {self.kind} needs at least {least} x {least} inner corners, "
                f"got {self.columns} x {self.rows}."
            )
        if not 0 < self.square_m < 10:
            raise BenchError(f"Board.square_m must be in metres, 0..10, got {self.square_m}.")
        if self.kind == "charuco":
            if not 0 < self.marker_m < self.square_m:
                raise BenchError(
                    f"Board.marker_m must be between 0 and square_m = {self.square_m}, "
                    f"got {self.marker_m}."
                )
            if not (self.dictionary.startswith("DICT_") and hasattr(cv2.aruco, self.dictionary)):
                known = sorted(name for name in dir(cv2.aruco) if name.startswith("DICT_"))
                raise BenchError(
                    f"No ArUco dictionary {self.dictionary!r}. Known: {', '.join(known)}."
                )

    @property
    def corners_m(self) -> Floats:
        """Inner corners (columns * rows, 3) [m] on the board (z = 0), row by row."""
        y, x = np.mgrid[0 : self.rows, 0 : self.columns]
        flat = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
        return np.asarray(flat * self.square_m, dtype=np.float64)


@dataclass(frozen=True, eq=False)
class Corners:
    """Inner corners detected in a picture: ids (n,) into `Board.corners_m`, pixels (n, 2) [px]."""

    ids: np.ndarray
    pixels: Floats

    def __len__(self) -> int:
        return len(self.ids)


def charuco_board(board: Board, legacy: bool = False) -> cv2.aruco.CharucoBoard:
    """OpenCV's record of a ChArUco board (it counts squares, not corners).

    legacy: with the colours of the squares as before OpenCV 4.6.
    """
    dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, board.dictionary))
    squares = (board.columns + 1, board.rows + 1)
    made = cv2.aruco.CharucoBoard(squares, board.square_m, board.marker_m, dictionary)
    made.setLegacyPattern(legacy)
    return made


def find_corners(board: Board, picture: np.ndarray) -> Corners | None:
    """Detect the corners of the board in a picture uint8 BGR (h, w, 3) or grey (h, w).

    None where there is no board. A chessboard counts only when all corners are seen. Which of its
    ends comes first is not known where it looks the same upside down: see `turned`.
    """
    grey = cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY) if picture.ndim == 3 else picture
    if board.kind == "charuco":
        detected_charuco = _charuco_corners(board, grey)
        if detected_charuco is None:
            return None
        corner_ids, pixels = detected_charuco
        # The window must stay clear of the markers inside the squares.
        clear = (board.square_m - board.marker_m) / (2 * board.square_m)
        return Corners(corner_ids, _refined(board, grey, corner_ids, np.asarray(pixels), clear))
    size = (board.columns, board.rows)
    for detect, flags in _CHESSBOARD_SEARCHES:
        detected, pixels = detect(grey, size, flags=flags)
        if detected:
            all_ids = np.arange(board.columns * board.rows)
            return Corners(all_ids, _refined(board, grey, all_ids, np.asarray(pixels), 0.3))
    return None


def _charuco_corners(board: Board, grey: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
    """Ids and pixels of the corners; the board may be white on black, or of the older pattern."""
    for inverted in (False, True):
        parameters = cv2.aruco.DetectorParameters()
        parameters.detectInvertedMarker = inverted
        for legacy in (False, True):
            detector = cv2.aruco.CharucoDetector(
                charuco_board(board, legacy), detectorParams=parameters
            )
            pixels, ids, _, markers = detector.detectBoard(grey)
            if ids is not None and len(ids) >= CHARUCO_CORNERS_MIN:
                return np.ravel(ids).astype(np.intp), pixels
            if markers is None or len(markers) == 0:
                break  # the pattern makes no difference
    return None


def markers_seen(board: Board, picture: np.ndarray) -> int:
    """Number of markers of a ChArUco board's dictionary in a picture; 0 for a chessboard."""
    if board.kind != "charuco":
        return 0
    parameters = cv2.aruco.DetectorParameters()
    parameters.detectInvertedMarker = True
    dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, board.dictionary))
    _, ids, _ = cv2.aruco.ArucoDetector(dictionary, parameters).detectMarkers(picture)
    return 0 if ids is None else len(ids)


def _refined(
    board: Board, grey: np.ndarray, ids: np.ndarray, pixels: np.ndarray, share: float
) -> Floats:
    """Corners (n, 2) where the grey level's gradients say, within `share` of a square.

    Measured on boards rendered with a known pose: the sector detector alone is off by 0.10 px
    (standard deviation), after this by 0.016 px.
    """
    pixels = np.asarray(pixels, np.float32).reshape(-1, 2)
    where = np.full(board.columns * board.rows, np.nan)
    x, y = where.copy(), where.copy()
    x[ids], y[ids] = pixels[:, 0], pixels[:, 1]
    shape = (board.rows, board.columns)
    x, y = x.reshape(shape), y.reshape(shape)
    sides = np.concatenate(
        [np.hypot(np.diff(x, axis=i), np.diff(y, axis=i)).ravel() for i in (0, 1)]
    )
    sides = sides[np.isfinite(sides)]
    half = int(share * sides.min()) if len(sides) else 0
    if half < REFINE_MIN_PX:
        return pixels.astype(np.float64)
    half = min(half, REFINE_MAX_PX)
    stop = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 100, 1e-4)
    fine = cv2.cornerSubPix(grey, pixels.reshape(-1, 1, 2).copy(), (half, half), (-1, -1), stop)
    fine = np.asarray(fine).reshape(-1, 2)
    # A search that went further ended at a marker or at the board's rim.
    strayed = np.linalg.norm(fine - pixels, axis=1) > max(1.0, half / 3)
    return np.where(strayed[:, None], pixels, fine).astype(np.float64)


def turned(board: Board, corners: Corners) -> Corners:
    """Number the corners from the other end: the board turned by 180 degrees."""
    n = board.columns * board.rows
    return Corners(n - 1 - corners.ids, corners.pixels)


def draw_corners(board: Board, picture: np.ndarray, corners: Corners | None) -> np.ndarray:
    """Draw the corners into a copy of a BGR picture (h, w, 3)."""
    drawn = picture.copy()
    if corners is None:
        return drawn
    pixels = corners.pixels.astype(np.float32).reshape(-1, 1, 2)
    if board.kind == "charuco":
        cv2.aruco.drawDetectedCornersCharuco(drawn, pixels, corners.ids.astype(np.int32)[:, None])
    else:
        cv2.drawChessboardCorners(drawn, (board.columns, board.rows), pixels, True)
    return drawn
