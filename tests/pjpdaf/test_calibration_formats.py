"""Calibrations of other programs give the same rig as our own files."""

from __future__ import annotations

import dataclasses
import re

import numpy as np
import pytest
from rendered_boards import example_rig

from pjpdaf.calibration import read_rig, rectify, view_order_doubt, write_rig
from pjpdaf.camera import StereoRig
from pjpdaf.errors import BenchError

RIG = example_rig()
LENS = np.array([-0.1, 0.02, 0.001, -0.002])


def lensed(n=5):
    lens = np.append(LENS, np.zeros(n - 4))
    return StereoRig(*(dataclasses.replace(c, distortion=lens) for c in RIG.cameras))


def flat(array):
    return "[" + ", ".join(f"{x:.12g}" for x in np.ravel(array)) + "]"


def ros(folder, rig):
    """A pair as ROS's camera_calibration writes it."""
    R1, R2, P1, P2, *_ = rectify(rig)
    files = []
    for name, camera, R, P in (("left", rig.left, R1, P1), ("right", rig.right, R2, P2)):
        file = folder / f"{name}.yaml"
        file.write_text(
            f"image_width: {camera.width_px}\nimage_height: {camera.height_px}\n"
            f"camera_name: narrow_stereo/{name}\n"
            f"camera_matrix:\n  rows: 3\n  cols: 3\n  data: {flat(camera.K)}\n"
            "distortion_model: plumb_bob\n"
            f"distortion_coefficients:\n  rows: 1\n  cols: 5\n  data: {flat(camera.distortion)}\n"
            f"rectification_matrix:\n  rows: 3\n  cols: 3\n  data: {flat(R)}\n"
            f"projection_matrix:\n  rows: 3\n  cols: 4\n  data: {flat(P)}\n"
        )
        files.append(file)
    return files


def kalibr(folder, rig):
    """A camera chain as kalibr_calibrate_cameras writes it."""
    lines = []
    for name, camera in zip(("cam0", "cam1"), rig.cameras, strict=True):
        K = camera.K
        lines.append(f"{name}:")
        if name == "cam1":
            M = np.eye(4)
            M[:3, :3], M[:3, 3] = rig.R, rig.T
            lines += ["  T_cn_cnm1:", *(f"  - {flat(row)}" for row in M)]
        lines += [
            "  cam_overlaps: [1]",
            "  camera_model: pinhole",
            f"  distortion_coeffs: {flat(camera.distortion)}",
            "  distortion_model: radtan",
            f"  intrinsics: {flat([K[0, 0], K[1, 1], K[0, 2], K[1, 2]])}",
            f"  resolution: [{camera.width_px}, {camera.height_px}]",
            f"  rostopic: /{name}/image_raw",
        ]
    file = folder / "camchain.yaml"
    file.write_text("\n".join(lines) + "\n")
    return file


def assert_same(a, b):
    for one, other in zip(a.cameras, b.cameras, strict=True):
        np.testing.assert_allclose(one.K, other.K, rtol=1e-10)
        np.testing.assert_allclose(one.distortion, other.distortion, atol=1e-10)
        assert (one.width_px, one.height_px) == (other.width_px, other.height_px)
    np.testing.assert_allclose(a.R, b.R, atol=1e-9)
    np.testing.assert_allclose(a.T, b.T, atol=1e-9)


def test_a_pair_of_ros_camera_info(tmp_path):
    rig = lensed()
    assert_same(read_rig(*ros(tmp_path, rig)), rig)


def test_a_chain_of_kalibr(tmp_path):
    rig = lensed(4)
    file = kalibr(tmp_path, rig)
    assert_same(read_rig(file, file), rig)
    assert_same(read_rig(file), rig)


@pytest.mark.parametrize(
    ("names", "form"),
    [
        (("M1", "D1", "M2", "D2"), "utf-8-sig"),
        (("K1", "D1", "K2", "D2"), "utf-8"),
        (("cameraMatrix1", "distCoeffs1", "cameraMatrix2", "distCoeffs2"), "utf-16"),
    ],
)
def test_other_names_and_byte_order_marks_in_one_file(tmp_path, names, form):
    inner, outer = write_rig(RIG, tmp_path)
    text = inner.read_text()
    for old, new in zip(("M1", "D1", "M2", "D2"), names, strict=True):
        text = text.replace(f"\n{old}:", f"\n{new}:")
    text += outer.read_text().split("---\n")[1]
    file = tmp_path / "stereo.yml"
    file.write_text(text.replace("\n", "\r\n"), encoding=form)
    assert_same(read_rig(file), RIG)


FAULTS = [
    ("   cols: 3\n", "", "M1 is not a matrix: it has no rows and cols"),
    ("data: [ 430., ", "data: [ ", "M1 is 3x3 but its data have 8 numbers"),
    ("rows: 3", "rows: 30000", "M1 has no size of a matrix"),
    ("rows: 3", "rows: -3", "M1 has no size of a matrix"),
    ("dt: d", 'dt: "9u"', "M1 is not a matrix of numbers"),
    ("data: [ 430.,", "data: [ x,", "M1 has values that are no numbers"),
    ("data: [ 430.,", "data: [ 1e9,", "M1 must be .* in pixels"),
    ("image_width: 480", "image_width: 1000000000", "must be whole numbers of 1 to 20000"),
]


@pytest.mark.parametrize(("old", "new", "words"), FAULTS)
def test_a_matrix_is_checked_before_it_is_read(tmp_path, old, new, words):
    inner, _ = write_rig(RIG, tmp_path)
    text = inner.read_text()
    assert old in text
    inner.write_text(text.replace(old, new, 1))
    with pytest.raises(BenchError, match=words):
        read_rig(tmp_path)


def test_a_lens_of_nonsense(tmp_path):
    inner, _ = write_rig(lensed(), tmp_path)
    inner.write_text(re.sub(r"-1.0\d*e-01|-0.1\d*", "2e9", inner.read_text()))
    with pytest.raises(BenchError, match=r"D1 has the coefficient 2e\+09: no lens is like that"):
        read_rig(tmp_path)


@pytest.mark.parametrize("part", ["[", "{a: ", "- ", "<a>"])
def test_nesting_that_ends_the_parser_is_refused_before(tmp_path, part):
    file = tmp_path / "deep.yml"
    file.write_text(("%YAML:1.0\n---\nA: " if part != "<a>" else "<?xml?>") + part * 100_000)
    with pytest.raises(BenchError, match="it has too many parts"):
        read_rig(file)


@pytest.mark.parametrize("head", [b"MATLAB 5.0 MAT-file, Platform", b"\x89HDF\r\n\x1a\n\0\0"])
def test_a_file_of_matlab_names_the_way_to_convert(tmp_path, head):
    file = tmp_path / "stereoParams.mat"
    file.write_bytes(head + bytes(300))
    with pytest.raises(BenchError, match="stereoParametersToOpenCV"):
        read_rig(file)


def test_one_line_for_what_cannot_be_a_stereo_calibration(tmp_path):
    left, right = ros(tmp_path, lensed())
    with pytest.raises(BenchError, match="give the other camera's file too"):
        read_rig(left)
    text = right.read_text()
    P = text.rpartition("data: [")[2]
    alone = P.split(", ")
    alone[3] = "0"
    right.write_text(text.replace(P, ", ".join(alone)))
    with pytest.raises(BenchError, match="projection_matrix has no baseline"):
        read_rig(left, right)
    right.write_text(text.replace("plumb_bob", "equidistant"))
    with pytest.raises(BenchError, match="distortion_model 'equidistant': plumb_bob or"):
        read_rig(left, right)
    chain = kalibr(tmp_path, lensed(4))
    chain.write_text(chain.read_text().replace("radtan", "equidistant"))
    with pytest.raises(BenchError, match="cam0 is pinhole equidistant: pinhole radtan is needed"):
        read_rig(chain)


def test_exchanged_views_are_doubted():
    assert view_order_doubt(RIG) == ""
    turned = StereoRig(RIG.left, dataclasses.replace(RIG.right, t_cw=-RIG.right.t_cw))
    assert "is 160 mm to the left of the left one (T_x is above 0)" in view_order_doubt(turned)
