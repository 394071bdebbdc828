"""Calibration files, and calibration from rendered boards whose truth is known."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import cv2
import numpy as np
import pytest

from pjpdaf.boards import Board, Corners, charuco_board, find_corners, turned
from pjpdaf.calibrate import calibrate
from pjpdaf.calibration import read_rig, write_rig
from pjpdaf.camera import Camera, StereoRig
from pjpdaf.errors import BenchError
from pjpdaf.sources import PicturePair, picture_pairs

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


@pytest.fixture(scope="module")
def chess_pairs() -> list[PicturePair]:
    return picture_pairs_of(CHESS, example_rig(), 10)


# --- files ---


def test_files_come_back_as_written(tmp_path):
    rig = example_rig()
    paths = write_rig(rig, tmp_path / "new")
    assert [p.name for p in paths] == ["intrinsics.yml", "extrinsics.yml"]
    for back in (read_rig(tmp_path / "new"), read_rig(*paths), read_rig(paths[0])):
        for a, b in zip(rig.cameras, back.cameras, strict=True):
            np.testing.assert_array_equal(a.K, b.K)
            np.testing.assert_array_equal(a.distortion, b.distortion)
            np.testing.assert_allclose(a.R_cw, b.R_cw, atol=1e-15)
            np.testing.assert_allclose(a.t_cw, b.t_cw, atol=1e-15)
            assert (a.width_px, a.height_px) == (b.width_px, b.height_px)


def test_files_have_the_samples_keys_and_a_world_that_is_not_the_left_camera_is_left_out(tmp_path):
    rig = example_rig()
    S, s = rotation(0.3, 0.1, -0.7), np.array([0.5, 1.0, 2.0])
    moved = StereoRig(
        *(dataclasses.replace(c, R_cw=c.R_cw @ S, t_cw=c.R_cw @ s + c.t_cw) for c in rig.cameras)
    )
    write_rig(moved, tmp_path)
    storage = cv2.FileStorage(str(tmp_path / "extrinsics.yml"), cv2.FILE_STORAGE_READ)
    keys = storage.root().keys()
    storage.release()
    assert list(keys) == ["R", "T", "R1", "R2", "P1", "P2", "Q"]
    back = read_rig(tmp_path)
    np.testing.assert_array_equal(back.left.R_cw, np.eye(3))
    np.testing.assert_allclose(back.right.R_cw, rig.R, atol=1e-14)
    np.testing.assert_allclose(back.right.t_cw, rig.T, atol=1e-14)


@pytest.mark.parametrize("n", [4, 5, 8, 12, 14])
def test_every_lens_model_is_read_as_row_or_column(tmp_path, n):
    rig = example_rig()
    lens = np.linspace(0.01, 0.02, n)
    rig = StereoRig(*(dataclasses.replace(c, distortion=lens) for c in rig.cameras))
    inner, outer = write_rig(rig, tmp_path)
    text = inner.read_text().replace(f"rows: 1\n   cols: {n}", f"rows: {n}\n   cols: 1")
    assert f"rows: {n}" in text
    inner.write_text(text)
    np.testing.assert_array_equal(read_rig(inner, outer).right.distortion, lens)


def test_the_samples_file_without_size_and_rectification(tmp_path):
    inner, outer = write_rig(example_rig(), tmp_path)
    inner.write_text("".join(s for s in inner.read_text().splitlines(True) if "image_" not in s))
    lines = outer.read_text().splitlines(keepends=True)
    start = next(i for i, line in enumerate(lines) if line.startswith("R1:"))
    outer.write_text("".join(lines[:start]).replace("%YAML 1.2", "%YAML:1.0"))
    assert read_rig(inner, outer, (WIDTH, HEIGHT)).left.width_px == WIDTH
    with pytest.raises(BenchError, match=r"intrinsics.yml: keys image_width and image_height"):
        read_rig(inner, outer)


def test_millimetres(tmp_path):
    rig = example_rig()
    mm = StereoRig(rig.left, dataclasses.replace(rig.right, t_cw=1000 * rig.right.t_cw))
    write_rig(mm, tmp_path)
    with pytest.raises(BenchError, match=r"extrinsics.yml: T is 160\.\d+ m long"):
        read_rig(tmp_path)
    np.testing.assert_allclose(read_rig(tmp_path, unit_m=0.001).T, rig.T)


MATRIX = "!!opencv-matrix\n   rows: {}\n   cols: {}\n   dt: d\n   data: [ {} ]\n"


def replaced(text: str, key: str, value: str) -> str:
    """`text` with the matrix of `key` replaced."""
    before, after = text.split(f"\n{key}: ", 1)
    rest = after.split("]\n", 1)[1]
    return f"{before}\n{key}: {value}{rest}"


FAULTS = [
    ("intrinsics", "M2", MATRIX.format(1, 9, "540., 0., 1., 0., 540., 1., 0., 0., 1."), "M2 must"),
    ("intrinsics", "M1", MATRIX.format(3, 3, "-5., 0., 1., 0., 540., 1., 0., 0., 1."), "fx, fy"),
    ("intrinsics", "M1", MATRIX.format(3, 3, ".Nan, 0., 1., 0., 5., 1., 0., 0., 1."), "finite"),
    ("intrinsics", "M1", "7\n#]\n", "M1 is not a matrix"),
    ("intrinsics", "D1", MATRIX.format(1, 3, "0., 0., 0."), "D1 must be a row or column of 4, 5"),
    ("intrinsics", "D2", None, "key D2 is missing. It has D1, M1, M2"),
    ("extrinsics", "R", None, "key R is missing"),
    ("extrinsics", "R", MATRIX.format(3, 3, "1., 0., 0., 0., 1., .1, 0., 0., 1."), "not a rotat"),
    ("extrinsics", "R", MATRIX.format(3, 3, "-1., 0., 0., 0., 1., 0., 0., 0., 1."), "det R = -1"),
    ("extrinsics", "T", MATRIX.format(3, 1, "0., 0., 0."), "T is zero"),
    ("extrinsics", "T", MATRIX.format(2, 1, "1., 0."), "T must be 3x1, got 2x1"),
]


@pytest.mark.parametrize(("file", "key", "value", "words"), FAULTS)
def test_a_fault_names_file_and_key_in_one_line(tmp_path, file, key, value, words):
    write_rig(example_rig(), tmp_path)
    path = tmp_path / f"{file}.yml"
    path.write_text(
        replaced(path.read_text(), key, value or "0\n").replace(
            f"\n{key}: 0\n", "\n" if value is None else f"\n{key}: 0\n"
        )
    )
    with pytest.raises(BenchError) as fault:
        read_rig(tmp_path)
    message = str(fault.value)
    assert f"{file}.yml" in message
    assert words in message
    assert "\n" not in message


@pytest.mark.parametrize(
    "text", ["", "hello: [1,2", "M1 = 3\n", "\0\1\2" * 99, "%YAML:1.0\n---\nM1: !!opencv-matrix\n"]
)
def test_not_yaml_is_one_line(tmp_path, text, capfd):
    write_rig(example_rig(), tmp_path)
    (tmp_path / "intrinsics.yml").write_text(text)
    with pytest.raises(BenchError, match=r"intrinsics\.yml: ") as fault:
        read_rig(tmp_path)
    assert "\n" not in str(fault.value)
    assert capfd.readouterr().err == ""


def test_missing_files(tmp_path):
    with pytest.raises(BenchError, match=r"intrinsics\.yml: no such calibration file"):
        read_rig(tmp_path)
    inner, outer = write_rig(example_rig(), tmp_path)
    outer.unlink()
    with pytest.raises(BenchError, match=r"extrinsics\.yml: no such calibration file"):
        read_rig(inner)


def test_another_resolution_is_refused(tmp_path):
    write_rig(example_rig(), tmp_path)
    with pytest.raises(BenchError, match=r"calibrated at 480x360 px .* pictures are 640x480"):
        read_rig(tmp_path, size_px=(640, 480))


# --- boards ---


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


# --- calibrate ---


def assert_recovered(report, truth: StereoRig) -> None:
    """Every intrinsic within 4.5 of its own standard deviations; rig within 0.1 deg and 1 mm."""
    for camera, true, sd in (
        (report.rig.left, truth.left, report.sd_left),
        (report.rig.right, truth.right, report.sd_right),
    ):
        found = np.r_[camera.K[0, 0], camera.K[1, 1], camera.K[:2, 2], camera.distortion]
        want = np.r_[true.K[0, 0], true.K[1, 1], true.K[:2, 2], true.distortion]
        # 18 numbers; corner errors are not quite independent, so a little more than 3 sigma.
        np.testing.assert_array_less(np.abs(found - want), 4.5 * sd)
        assert sd[0] < 5.0  # and the uncertainty itself is small
    angle = np.degrees(np.linalg.norm(cv2.Rodrigues(report.rig.R @ truth.R.T)[0]))
    assert angle < 0.5
    assert np.linalg.norm(report.rig.T - truth.T) < 0.003


def test_chessboard_calibration_recovers_the_rig(chess_pairs, tmp_path):
    report = calibrate(chess_pairs, CHESS, tmp_path)
    assert_recovered(report, example_rig())
    assert report.used == len(chess_pairs)
    assert report.rms_stereo_px < 0.2
    assert report.epipolar_px < 0.2
    assert report.baseline_m == pytest.approx(np.linalg.norm(example_rig().T), abs=0.003)
    assert all(f.is_file() for f in report.files)
    assert {"intrinsics.yml", "extrinsics.yml", "rectified.png"} <= {f.name for f in report.files}
    assert len(list((tmp_path / "corners").iterdir())) == 2 * len(chess_pairs)
    np.testing.assert_allclose(read_rig(tmp_path).T, report.rig.T, atol=1e-12)
    rectified = cv2.imread(str(tmp_path / "rectified.png"))
    assert rectified.shape == (HEIGHT, 2 * WIDTH, 3)


def test_charuco_calibration_recovers_the_rig():
    report = calibrate(picture_pairs_of(CHARUCO, example_rig(), 10), CHARUCO)
    assert_recovered(report, example_rig())
    assert report.files == ()


def test_bad_pairs_are_left_out_and_named(chess_pairs):
    blank = np.full((HEIGHT, WIDTH, 3), 128, np.uint8)
    bad = list(chess_pairs)
    bad[0] = dataclasses.replace(bad[0], pictures=(blank, bad[0].pictures[1]))
    bad[1] = dataclasses.replace(bad[1], pictures=(bad[1].pictures[0], None))
    # The board moved between the two exposures.
    bad[2] = dataclasses.replace(bad[2], pictures=(bad[2].pictures[0], bad[5].pictures[1]))
    report = calibrate(bad, CHESS)
    assert [p.used for p in report.pairs] == [False] * 3 + [True] * 7
    assert report.pairs[0].reason == "no board found in left"
    assert report.pairs[1].reason == "no readable picture in right"
    assert report.pairs[2].reason.startswith("reprojection outlier: ")
    assert np.isnan(report.pairs[2].error_left_px)
    assert max(p.error_left_px for p in report.pairs if p.used) < 0.5
    assert np.linalg.norm(report.rig.T - example_rig().T) < 0.005


def test_boards_numbered_from_the_other_end_are_turned_back(chess_pairs, monkeypatch):
    upside_down = {id(chess_pairs[i].pictures[1]) for i in (1, 4, 5, 8)}

    def numbered(board: Board, picture: np.ndarray) -> Corners | None:
        corners = find_corners(board, picture)
        # As a detector that starts at the other end: same ids, pixels in reverse.
        if corners is not None and id(picture) in upside_down:
            return Corners(corners.ids, corners.pixels[::-1])
        return corners

    straight = calibrate(chess_pairs, CHESS)
    monkeypatch.setattr("pjpdaf.calibrate.find_corners", numbered)
    report = calibrate(chess_pairs, CHESS)
    changed = [a.turned != b.turned for a, b in zip(report.pairs, straight.pairs, strict=True)]
    assert changed == [i in (1, 4, 5, 8) for i in range(10)]
    assert all(pair.used for pair in report.pairs)
    np.testing.assert_allclose(report.rig.T, straight.rig.T, atol=1e-3)


def test_too_few_boards_is_one_line_with_the_reasons(chess_pairs):
    with pytest.raises(BenchError) as fault:
        calibrate(chess_pairs[:3], CHESS)
    assert "at least 4 pairs that show the board in both views, got 3 of 3" in str(fault.value)
    wrong = dataclasses.replace(CHESS, columns=7, rows=7)
    with pytest.raises(BenchError, match=r"0\.png: no board found in left and right.*inner corn"):
        calibrate(chess_pairs[:1], wrong)


def test_pictures_of_two_sizes_are_refused(chess_pairs):
    small = np.zeros((10, 20, 3), np.uint8)
    mixed = [chess_pairs[0], PicturePair(1, ("a.png", "b.png"), (small, small))]
    with pytest.raises(BenchError, match=r"a\.png: the picture is 20x10 px, the others 480x360"):
        calibrate(mixed, CHESS)


def test_calibration_from_folders(chess_pairs, tmp_path):
    for view, name in enumerate(("left", "right")):
        (tmp_path / name).mkdir()
        for pair in chess_pairs[:5]:
            cv2.imwrite(str(tmp_path / name / f"{pair.index}.png"), pair.pictures[view])
    (tmp_path / "right" / "3.png").write_bytes(b"nothing")
    said: list[str] = []
    report = calibrate(
        picture_pairs(tmp_path / "left", tmp_path / "right", said.append), CHESS, None, 4
    )
    assert [p.used for p in report.pairs] == [True, True, True, False, True]
    assert Path(report.pairs[3].right).name == "3.png"
    assert len(said) == 1
    assert len(report.rig.left.distortion) == 4


def test_an_unknown_lens_model_is_refused():
    with pytest.raises(BenchError, match="one of 4, 5, 8, 12, 14 coefficients, got 6"):
        calibrate([], CHESS, coefficients=6)
