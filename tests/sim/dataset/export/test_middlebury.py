"""Middlebury's files: disparity by OpenCV's reader of PFM, depth by the formula of calib.txt."""

import re

import cv2
import numpy as np
import pytest

from pjpdaf.calibration import rectify
from sim.dataset.export.middlebury import BOTH, NONE, export
from sim.dataset.labels.records import SEEN


@pytest.fixture(scope="module")
def folders(dataset, tmp_path_factory):
    into = tmp_path_factory.mktemp("middlebury")
    export(dataset, into)
    return {path.name: path for path in (into / "middlebury").iterdir()}


def frames(dataset):
    """Name, sequence and index of the frames of which both pictures arrived."""
    for sequence in dataset.sequences:
        for index in range(sequence.frame_count):
            if all(picture is not None for picture in sequence.frame(index).pictures):
                yield f"{sequence.name}_{index + 1:06d}", sequence, index


def calib(path):
    return dict(line.split("=") for line in (path / "calib.txt").read_text().splitlines())


def read_pfm(path):
    """As Middlebury's own reader does."""
    with path.open("rb") as file:
        assert file.readline() == b"Pf\n"
        width, height = map(int, file.readline().split())
        assert float(file.readline()) < 0  # little endian
        return np.frombuffer(file.read(), "<f4").reshape(height, width)[::-1]


def test_a_folder_a_frame_with_both_pictures(dataset, folders):
    assert set(folders) == {name for name, *_ in frames(dataset)}
    wanted = {
        f"{kind}{v}{end}"
        for v in (0, 1)
        for kind, end in (("im", ".png"), ("disp", ".pfm"), ("mask", "nocc.png"))
    } | {"calib.txt"}
    assert all({p.name for p in path.iterdir()} == wanted for path in folders.values())


def test_disparity_is_the_data_sets_by_two_readers(dataset, folders):
    for name, sequence, index in frames(dataset):
        for view in (0, 1):
            own = sequence.rectified(view, index)
            path = folders[name] / f"disp{view}.pfm"
            disparity = read_pfm(path)
            np.testing.assert_array_equal(cv2.imread(str(path), cv2.IMREAD_UNCHANGED), disparity)
            known = np.isfinite(own.disparity_px)
            np.testing.assert_array_equal(np.isfinite(disparity), known)
            np.testing.assert_array_equal(disparity[known], own.disparity_px[known])
            assert np.isposinf(disparity[~known]).all()
            mask = cv2.imread(str(folders[name] / f"mask{view}nocc.png"), cv2.IMREAD_UNCHANGED)
            np.testing.assert_array_equal(mask == BOTH, known & (own.status == SEEN))
            np.testing.assert_array_equal(mask == NONE, ~known)
        assert int(calib(folders[name])["ndisp"]) > disparity[known].max()


def test_the_formula_of_calib_gives_the_depth(dataset, folders):
    """On a rig whose cameras converge by 2 mrad: rectified depth is a thousandth of it off."""
    name, sequence, index = next(frames(dataset))
    values = calib(folders[name])
    f = float(re.match(r"\[(\S+) 0", values["cam0"])[1])
    disparity = read_pfm(folders[name] / "disp0.pfm")
    depth_m = 1e-3 * float(values["baseline"]) * f / (disparity + float(values["doffs"]))
    R1 = rectify(sequence.rig)[0]
    assert np.abs(R1 - np.eye(3)).max() < 2e-3
    off = np.abs(depth_m / sequence.depth_m(0, index) - 1)
    assert np.nanmedian(off) < 2e-3


def test_rectified_pictures_match_by_their_disparity(dataset, folders):
    """A pixel seen in both pictures has the same colour in both, noise apart."""
    for name, sequence, _ in frames(dataset):
        left, right = (cv2.imread(str(folders[name] / f"im{v}.png")).astype(float) for v in (0, 1))
        disparity = read_pfm(folders[name] / "disp0.pfm")
        mask = cv2.imread(str(folders[name] / "mask0nocc.png"), cv2.IMREAD_UNCHANGED) == BOTH
        ys, xs = np.nonzero(mask)
        there = np.rint(xs - disparity[ys, xs]).astype(int)
        inside = (there >= 0) & (there < left.shape[1])
        ys, xs, there = ys[inside], xs[inside], there[inside]
        straight = np.abs(left[ys, xs] - right[ys, there]).mean()
        shifted = np.abs(left[ys, xs] - right[ys, np.minimum(there + 6, left.shape[1] - 1)]).mean()
        assert straight < 0.8 * shifted, (sequence.name, straight, shifted)
