"""`calibrate` as users start it, on boards that sim rendered through a known lens."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from pjpdaf.boards import Board, charuco_board
from pjpdaf.camera import Camera, StereoRig
from sim.gl import load_mujoco
from sim.render import StereoRenderer
from sim.world import compiled

ROOT = Path(__file__).parents[2]
WIDTH, HEIGHT = 640, 480
CHESS = Board("chessboard", 9, 6, 0.025)
CHARUCO = Board("charuco", 6, 4, 0.036, 0.027, "DICT_5X5_100")
TEXTURE_PX = 40  # per square
PAIRS = 16


def turn(*vector):
    return cv2.Rodrigues(np.array(vector))[0]


def true_rig():
    """Two unlike cameras with unlike lenses, toed in, in the left camera's frame."""
    left = np.array([[545.0, 0, 326.3], [0, 541.0, 233.1], [0, 0, 1]])
    right = np.array([[538.0, 0, 312.9], [0, 543.0, 246.4], [0, 0, 1]])
    R, T = turn(0.01, 0.12, -0.008), np.array([-0.09, 0.002, 0.006])
    return StereoRig(
        Camera(left, np.eye(3), np.zeros(3), WIDTH, HEIGHT, [-0.21, 0.08, 0.001, -0.0008, 0.0]),
        Camera(right, R, T, WIDTH, HEIGHT, [-0.17, 0.05, -0.0012, 0.0006, 0.0]),
    )


def texture(board):
    """The board with a margin of one square, uint8 grey; column 0 is the board's left."""
    squares = np.array([board.columns + 1, board.rows + 1])
    if board.kind == "charuco":
        size = tuple(((squares + 2) * TEXTURE_PX).tolist())
        return charuco_board(board).generateImage(size, marginSize=TEXTURE_PX)
    y, x = np.mgrid[0 : squares[1], 0 : squares[0]]
    cells = np.where((x + y) % 2 == 0, 20, 235).astype(np.uint8)
    return np.kron(np.pad(cells, 1, constant_values=235), np.ones((TEXTURE_PX,) * 2, np.uint8))


def poses(board):
    """Rotation and position of the board's middle in the left camera's frame, tilted all ways."""
    rng = np.random.default_rng(5)
    for i in range(PAIRS):
        tilt = 0.55 * np.array([np.cos(2.4 * i), np.sin(2.4 * i)])
        R = turn(*tilt, rng.uniform(-0.3, 0.3))
        depth = 0.42 + 0.05 * (i % 4)
        at = np.array(
            [0.045 + rng.uniform(-0.3, 0.3) * depth, rng.uniform(-0.22, 0.22) * depth, depth]
        )
        yield R, at


def board_world(board, rig):
    """Nothing but the board."""
    mujoco = load_mujoco()
    spec = mujoco.MjSpec()
    spec.visual.headlight.active = 0  # the board shines by itself: no shading
    grey = texture(board)
    height, width = grey.shape
    picture = spec.add_texture(
        name="board", type=mujoco.mjtTexture.mjTEXTURE_2D, width=width, height=height, nchannel=3
    )
    picture.data = np.ascontiguousarray(np.repeat(grey[..., None], 3, axis=2)).tobytes()
    material = spec.add_material(name="board", emission=0.9, specular=0, shininess=0)
    material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = "board"
    half = np.array([width, height]) / TEXTURE_PX * board.square_m / 2
    body = spec.worldbody.add_body(name="board", mocap=True)
    # A mesh of two triangles: its texture coordinates are ours, not MuJoCo's.
    x, y = half
    vertices = np.array([[-x, -y, 0], [x, -y, 0], [x, y, 0], [-x, y, 0], [0, 0, 0.001]])
    faces = [[0, 2, 1], [0, 3, 2], [0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]]
    corners = np.array([[0, 0], [1, 0], [1, 1], [0, 1], [0.5, 0.5]])
    spec.add_mesh(
        name="board",
        uservert=vertices.ravel().tolist(),
        userface=np.ravel(faces).tolist(),
        usertexcoord=corners.ravel().tolist(),
        inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL,
    )
    body.add_geom(name="board", type=mujoco.mjtGeom.mjGEOM_MESH, meshname="board", material="board")
    return compiled(spec, rig)


def render_boards(board, rig, folder):
    """Folders left and right of PNG pictures, with 1.5 grey levels of noise."""
    world = board_world(board, rig)
    mujoco = load_mujoco()
    rng = np.random.default_rng(8)
    for name in ("left", "right"):
        (folder / name).mkdir(parents=True)
    with StereoRenderer(world) as renderer:
        for i, (R, at) in enumerate(poses(board)):
            world.data.mocap_pos[0] = at
            mujoco.mju_mat2Quat(world.data.mocap_quat[0], np.ravel(R))
            world.settle()
            views = renderer.render(labels=False, amodal=False)
            for name, view in zip(("left", "right"), views, strict=True):
                noisy = view.colour + rng.normal(0, 1.5, view.colour.shape)
                picture = np.clip(noisy, 0, 255).round().astype(np.uint8)
                cv2.imwrite(str(folder / name / f"{i:02d}.png"), picture)


@pytest.fixture(scope="module")
def boards(tmp_path_factory):
    folder = tmp_path_factory.mktemp("boards")
    render_boards(CHESS, true_rig(), folder / "chess")
    return folder
