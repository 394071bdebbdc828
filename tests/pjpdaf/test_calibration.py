"""Calibration files: written and read alike, faults named."""

from __future__ import annotations

import dataclasses

import cv2
import numpy as np
import pytest
from rendered_boards import (
    HEIGHT,
    WIDTH,
    example_rig,
    rotation,
)

from pjpdaf.calibration import read_rig, write_rig
from pjpdaf.camera import StereoRig
from pjpdaf.errors import BenchError


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
