"""`calibrate` as users start it, on boards that sim rendered through a known lens."""

import re

import cv2
import numpy as np
import pytest
from commands import assert_one_line, in_this_process, messages

from pjpdaf.boards import Board, charuco_board
from pjpdaf.calibrate import calibrate
from pjpdaf.calibration import read_rig
from pjpdaf.camera import Camera, StereoRig
from pjpdaf.sources import picture_pairs
from sim.camera.render import StereoRenderer
from sim.gl import load_mujoco
from sim.scene.world import compiled

WIDTH, HEIGHT = 640, 480
CHESS = Board("chessboard", 9, 6, 0.025)
CHARUCO = Board("charuco", 6, 4, 0.036, 0.027, "DICT_5X5_100")
TEXTURE_PX = 40  # per square
PAIRS = 11


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


def bench(*words):
    return in_this_process("calibrate", *words)


def sides(folder):
    return "--left", folder / "left", "--right", folder / "right"


def assert_recovered(report, truth):
    """Intrinsics within 4.5 of their own standard deviations, the rig within its accuracy."""
    for camera, true, sd in (
        (report.rig.left, truth.left, report.sd_left),
        (report.rig.right, truth.right, report.sd_right),
    ):
        found = np.r_[camera.K[0, 0], camera.K[1, 1], camera.K[:2, 2], camera.distortion]
        want = np.r_[true.K[0, 0], true.K[1, 1], true.K[:2, 2], true.distortion]
        # 18 numbers, and the errors of neighbouring corners go together.
        np.testing.assert_array_less(np.abs(found - want), 4.5 * sd)
        assert sd[0] < 1.0
    angle_deg = np.degrees(np.linalg.norm(cv2.Rodrigues(report.rig.R @ truth.R.T)[0]))
    assert angle_deg < 0.3  # cx and the toe-in trade off: 1 px of cx is 0.1 deg
    assert np.linalg.norm(report.rig.T - truth.T) < 0.0015


@pytest.fixture(scope="module")
def chess(tmp_path_factory):
    """Folder of the chessboard's pictures, and the same with the faults that people make."""
    folder = tmp_path_factory.mktemp("chess")
    render_boards(CHESS, true_rig(), folder)
    (folder / "right" / "03.png").write_bytes(b"nothing")
    # The board moved between the two exposures.
    moved = (folder / "right" / "09.png").read_bytes()
    (folder / "right" / "10.png").write_bytes(moved)
    return folder


@pytest.mark.long
def test_the_command_recovers_the_cameras_and_names_bad_pairs(chess, tmp_path):
    out = tmp_path / "cal"
    done = bench(*sides(chess), "--board", "9x6", "--square", "0.025", "--out", out)
    assert done.returncode == 0, done.stderr
    assert len(messages(done)) == 1
    assert "03.png: cannot be read" in done.stderr
    rows = {
        n: line
        for n in range(PAIRS)
        for line in done.stdout.splitlines()
        if f" {n:02d}.png " in line
    }
    assert len(rows) == PAIRS
    assert "dropped: no readable picture in right" in rows[3]
    assert "dropped: reprojection outlier" in rows[10]
    errors = [float(e) for n in (0, 1, 2, 5) for e in re.findall(r" (0\.[0-9]{3})\b", rows[n])]
    assert len(errors) == 8
    assert max(errors) < 0.15
    assert "stereo 0.0" in done.stdout
    assert "baseline 9" in done.stdout
    names = {file.name for file in out.iterdir()}
    assert names == {"intrinsics.yml", "extrinsics.yml", "rectified.png", "corners"}
    assert len(list((out / "corners").iterdir())) == 2 * PAIRS - 1
    assert cv2.imread(str(out / "rectified.png")).shape == (HEIGHT, 2 * WIDTH, 3)
    truth, found = true_rig(), read_rig(out)
    assert abs(found.left.K[0, 0] - truth.left.K[0, 0]) < 2.5
    assert abs(np.linalg.norm(found.T) - np.linalg.norm(truth.T)) < 0.001


@pytest.mark.long
def test_a_rendered_chessboard_gives_the_parameters_within_their_uncertainty(chess):
    report = calibrate(picture_pairs(chess / "left", chess / "right"), CHESS)
    assert_recovered(report, true_rig())
    assert report.rms_stereo_px < 0.15


@pytest.mark.long
def test_a_rendered_charuco_board_likewise(tmp_path):
    render_boards(CHARUCO, true_rig(), tmp_path)
    words = ("--board", "6x4", "--square", "0.036", "--charuco", "5x5_100", "--marker", "0.027")
    done = bench(*sides(tmp_path), *words, "--out", tmp_path / "cal")
    assert done.returncode == 0, done.stderr
    assert f"{PAIRS} of {PAIRS} pairs used" in done.stdout
    report = calibrate(picture_pairs(tmp_path / "left", tmp_path / "right"), CHARUCO)
    assert_recovered(report, true_rig())
    np.testing.assert_allclose(read_rig(tmp_path / "cal").T, report.rig.T, atol=1e-9)


@pytest.mark.parametrize(
    ("changes", "fragments"),
    [
        ({"left": "nowhere"}, ("nowhere", "no such file or folder")),
        ({"left": "empty"}, ("empty", "no pictures")),
        ({"left": "right"}, ("the same",)),
        ({"left": "few"}, ("differ in length", "2 pictures")),
        ({"left": "few", "right": "few2"}, ("at least 4 pairs", "got 2 of 2")),
        ({"left": "few", "right": "small"}, ("320x240", "640x480")),
        ({"board": "9"}, ("--board", "9x6")),
        ({"board": "1x6"}, ("inner corners", "1 x 6")),
        ({"square": "25"}, ("metres", "25")),
        ({"marker": "0.02"}, ("--charuco",)),
        ({"charuco": "5x5_100"}, ("--marker",)),
        ({"charuco": "9x9", "marker": "0.02"}, ("DICT_9X9", "DICT_5X5_100")),
        ({"coefficients": "6"}, ("--coefficients", "6")),
        ({"out": "left"}, ("left", "not empty")),
    ],
    ids=str,
)
def test_a_fault_is_one_line(chess, tmp_path, changes, fragments):
    for name in ("empty", "few", "few2", "small"):
        (tmp_path / name).mkdir()
    for name in ("left", "right"):
        (tmp_path / name).symlink_to(chess / name)
    for i, name in enumerate(("00.png", "01.png")):
        (tmp_path / "few" / name).symlink_to(chess / "left" / name)
        (tmp_path / "few2" / name).symlink_to(chess / "right" / name)
        cv2.imwrite(str(tmp_path / "small" / f"{i}.png"), np.zeros((240, 320, 3), np.uint8))
    options = {"left": "left", "right": "right", "board": "9x6", "square": "0.025", "out": "out"}
    line = []
    for key, value in (options | changes).items():
        line += [f"--{key}", tmp_path / value if key in ("left", "right", "out") else value]
    assert_one_line(bench(*line), 2, *fragments)
    assert not (tmp_path / "out").exists()
    assert not list(tmp_path.glob(".out.part*"))
