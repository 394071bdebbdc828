"""Stereo calibration from rendered boards whose truth is known."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import cv2
import numpy as np
import pytest
from rendered_boards import (
    CHARUCO,
    CHESS,
    HEIGHT,
    WIDTH,
    example_rig,
    picture_pairs_of,
)

from pjpdaf.boards import Board, Corners, find_corners
from pjpdaf.calibrate import calibrate
from pjpdaf.calibration import read_rig
from pjpdaf.camera import StereoRig
from pjpdaf.errors import BenchError
from pjpdaf.sources import PicturePair, picture_pairs


@pytest.fixture(scope="module")
def chess_pairs() -> list[PicturePair]:
    return picture_pairs_of(CHESS, example_rig(), 10)


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


@pytest.mark.long
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


@pytest.mark.long
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
    messages: list[str] = []
    report = calibrate(
        picture_pairs(tmp_path / "left", tmp_path / "right", messages.append), CHESS, None, 4
    )
    assert [p.used for p in report.pairs] == [True, True, True, False, True]
    assert Path(report.pairs[3].right).name == "3.png"
    assert len(messages) == 1
    assert len(report.rig.left.distortion) == 4


def test_an_unknown_lens_model_is_refused():
    with pytest.raises(BenchError, match="one of 4, 5, 8, 12, 14 coefficients, got 6"):
        calibrate([], CHESS, coefficients=6)
