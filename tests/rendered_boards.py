"""Pictures of calibration boards, rendered through lenses whose truth is known."""

from __future__ import annotations

import cv2
import numpy as np

from pjpdaf.boards import Board, charuco_board
from pjpdaf.camera import Camera, StereoRig
from pjpdaf.sources import PicturePair

WIDTH, HEIGHT = 480, 360
CHESS = Board("chessboard", 8, 5, 0.03)
CHARUCO = Board("charuco", 5, 4, 0.042, 0.032)


def rotation(*vector: float) -> np.ndarray:
    return cv2.Rodrigues(np.array(vector))[0]


def example_rig() -> StereoRig:
    left = np.array([[430.0, 0, 236.3], [0, 433.0, 182.1], [0, 0, 1]])
    right = np.array([[427.0, 0, 243.9], [0, 429.0, 176.4], [0, 0, 1]])
    R, T = rotation(0.02, 0.3, 0.01), np.array([-0.16, 0.004, 0.012])
    lens = ([-0.21, 0.09, 0.001, -0.0008, 0.0], [-0.18, 0.05, -0.0012, 0.0006, 0.0])
    return StereoRig(
        Camera(left, np.eye(3), np.zeros(3), WIDTH, HEIGHT, lens[0]),
        Camera(right, R, T, WIDTH, HEIGHT, lens[1]),
    )


TEXTURE_PX = 40  # per square


def texture(board: Board) -> np.ndarray:
    """The board with a margin of one square; inner corner (i, j) lies between pixels."""
    squares = (board.columns + 1, board.rows + 1)
    if board.kind == "charuco":
        size = ((squares[0] + 2) * TEXTURE_PX, (squares[1] + 2) * TEXTURE_PX)
        return charuco_board(board).generateImage(size, marginSize=TEXTURE_PX)
    y, x = np.mgrid[0 : squares[1], 0 : squares[0]]
    cells = np.where((x + y) % 2 == 0, 0, 255).astype(np.uint8)
    cells = np.pad(cells, 1, constant_values=255)
    return np.kron(cells, np.ones((TEXTURE_PX, TEXTURE_PX), np.uint8))


def render(board: Board, camera: Camera, R: np.ndarray, t: np.ndarray, rng) -> np.ndarray:
    """The board at pose (R, t) in the world, through lens and all, 2 x 2 rays a pixel."""
    fine = 2
    y, x = np.mgrid[0 : HEIGHT * fine + 16, 0 : WIDTH * fine + 16] - 8  # 8 more on each side
    at = np.stack([x, y], -1) / fine + (1 / fine - 1) / 2
    criteria = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 20, 1e-8)
    rays = cv2.undistortPoints(
        at[::8, ::8].reshape(-1, 1, 2), camera.K.copy(), camera.distortion.copy(), criteria=criteria
    ).reshape(HEIGHT * fine // 8 + 2, WIDTH * fine // 8 + 2, 2)
    # Rays are smooth over the picture: solved every 4 px, linear between. (OpenCV's cubic
    # interpolation does not reproduce a straight line: it moved corners by 0.15 px.)
    maps = np.meshgrid(
        np.arange(WIDTH * fine, dtype=np.float32) / 8 + 1,
        np.arange(HEIGHT * fine, dtype=np.float32) / 8 + 1,
    )
    rays = np.dstack(
        [cv2.remap(rays[..., i].astype(np.float32), *maps, cv2.INTER_LINEAR) for i in (0, 1)]
    )
    # Board plane to camera: q = H (X, Y, 1).
    Rc, tc = camera.R_cw @ R, camera.R_cw @ t + camera.t_cw
    H = np.linalg.inv(np.column_stack([Rc[:, 0], Rc[:, 1], tc]))
    plane = np.dstack([rays, np.ones(rays.shape[:2])]) @ H.T
    XY = plane[..., :2] / plane[..., 2:] / board.square_m
    pixels = ((XY + 2) * TEXTURE_PX - 0.5).astype(np.float32)
    picture = cv2.remap(
        cv2.GaussianBlur(texture(board), (0, 0), 1.5),
        pixels[..., 0],
        pixels[..., 1],
        cv2.INTER_LINEAR,
        borderMode=cv2.BORDER_CONSTANT,
        borderValue=200,
    )
    picture = picture.reshape(HEIGHT, fine, WIDTH, fine).mean((1, 3))
    noisy = 0.8 * picture + 20 + rng.normal(0, 1.5, picture.shape)
    return cv2.cvtColor(np.clip(noisy, 0, 255).round().astype(np.uint8), cv2.COLOR_GRAY2BGR)


def poses(board: Board, n: int) -> list[tuple[np.ndarray, np.ndarray]]:
    """Board poses in the left camera's frame that both cameras see, tilted all ways."""
    rng = np.random.default_rng(3)
    middle = np.array([board.columns - 1, board.rows - 1, 0]) / 2 * board.square_m
    result = []
    for i in range(n):
        tilt = 0.5 * np.array([np.cos(2.4 * i), np.sin(2.4 * i)])
        R = rotation(*tilt, rng.uniform(-0.2, 0.2))
        depth = 0.40 + 0.03 * (i % 4)
        centre = np.array([rng.uniform(0.02, 0.09), rng.uniform(-0.05, 0.05), depth])
        result.append((R, centre - R @ middle))
    return result


def picture_pairs_of(board: Board, rig: StereoRig, n: int) -> list[PicturePair]:
    rng = np.random.default_rng(7)
    return [
        PicturePair(
            i,
            (f"left/{i}.png", f"right/{i}.png"),
            (render(board, rig.left, R, t, rng), render(board, rig.right, R, t, rng)),
        )
        for i, (R, t) in enumerate(poses(board, n))
    ]
