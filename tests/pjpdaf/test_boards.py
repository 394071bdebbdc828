"""Corners of boards in pictures, and boards that cannot be."""

from __future__ import annotations

import dataclasses

import cv2
import numpy as np
import pytest
from rendered_boards import (
    CHARUCO,
    CHESS,
    HEIGHT,
    WIDTH,
    example_rig,
    poses,
    render,
)

from pjpdaf.boards import charuco_board, find_corners, markers_seen, turned
from pjpdaf.errors import BenchError


@pytest.mark.parametrize("board", [CHESS, CHARUCO])
def test_corners_are_found_where_they_were_drawn(board):
    camera = example_rig().left
    R, t = poses(board, 1)[0]
    corners = find_corners(board, render(board, camera, R, t, np.random.default_rng(0)))
    assert corners is not None
    assert len(corners) >= 0.8 * board.columns * board.rows
    truth, _ = cv2.projectPoints(
        board.corners_m, cv2.Rodrigues(R)[0], t, camera.K.copy(), camera.distortion.copy()
    )
    truth = truth.reshape(-1, 2)
    straight = np.abs(corners.pixels - truth[corners.ids]).max()
    other = np.abs(corners.pixels - truth[turned(board, corners).ids]).max()
    # 1.5 grey levels of noise: 0.016 px standard deviation measured on the chessboard; the window
    # between ChArUco's markers is smaller.
    assert min(straight, other) < (0.08 if board is CHESS else 0.25)


@pytest.mark.parametrize("board", [CHESS, CHARUCO])
def test_no_board_no_corners(board):
    noise = np.random.default_rng(0).integers(0, 255, (HEIGHT, WIDTH, 3), dtype=np.uint8)
    assert find_corners(board, cv2.GaussianBlur(noise, (0, 0), 3)) is None


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"columns": 1}, "at least 3 x 3 inner corners"),
        ({"square_m": 30.0}, "square_m must be in metres"),
        ({"kind": "circles"}, "must be one of"),
        ({"kind": "charuco"}, "marker_m must be between"),
        ({"kind": "charuco", "marker_m": 0.02, "dictionary": "DICT_9"}, "Known: DICT_4X4_100"),
    ],
)
def test_an_impossible_board_is_refused(change, words):
    with pytest.raises(BenchError, match=words):
        dataclasses.replace(CHESS, **change)


@pytest.mark.parametrize("inverted", [False, True])
@pytest.mark.parametrize("legacy", [False, True])
def test_a_charuco_board_white_on_black_or_of_the_older_pattern(inverted, legacy):
    picture = charuco_board(CHARUCO, legacy).generateImage((720, 540), marginSize=40)
    corners = find_corners(CHARUCO, 255 - picture if inverted else picture)
    assert corners is not None
    assert len(corners) == CHARUCO.columns * CHARUCO.rows


def test_markers_of_another_board_are_counted():
    other = dataclasses.replace(CHARUCO, columns=CHARUCO.columns + 3, rows=CHARUCO.rows - 1)
    picture = charuco_board(other).generateImage((720, 540), marginSize=40)
    assert markers_seen(CHARUCO, picture) > 10
    assert markers_seen(CHESS, picture) == 0
