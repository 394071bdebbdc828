"""Rays into the rebuilt scene agree with the files, and tell where the files are wrong."""

import json
import shutil

import cv2
import numpy as np
import pytest
from small_dataset import SIZE_PX, simulation_of

from pjpdaf.errors import BenchError
from scenarios.play.recipe import sized
from scenarios.spec.draw import perform
from scenarios.spec.names import load_scenario
from sim.dataset.files import encode
from sim.dataset.raytruth import MOST_MEDIAN_M, MOST_WRONG, lines_of, pooled, ray_check
from sim.dataset.reader import open_dataset
from sim.dataset.stored_sequence import StoredSequence
from sim.dataset.writer import write_sequence
from sim.sequence import Simulation


@pytest.fixture(scope="module")
def moving(tmp_path_factory):
    """Hands that clap, filmed with shutter skew and jitter: each view is of a moment of its own."""
    folder = tmp_path_factory.mktemp("rays") / "seq_000000"
    folder.mkdir()
    overrides = {"frames": 6, "fps": 1.0, "background_frames": 0, "shutter_skew": 50, "jitter": 40}
    clapping = sized(perform(load_scenario("clap"), 151, overrides), SIZE_PX)
    with Simulation(clapping) as simulation:
        write_sequence(simulation, folder, ("seg", "depth"), {})
        yield simulation, StoredSequence(folder, {})


@pytest.mark.parametrize("number", [0, 1], ids=["pinhole", "lens"])
def test_rays_agree_with_the_files(dataset_made, number):
    sequence = open_dataset(dataset_made).sequences[number]
    with simulation_of(number) as simulation:
        figures = ray_check(simulation, sequence, [0, 3])
    assert figures.met
    assert figures.wrong_share < MOST_WRONG / 10
    assert np.all(figures.target_shares < MOST_WRONG)
    # Depth is rounded to 0.1 mm: the median of that alone is 0.025 mm.
    assert 2e-5 < figures.median_m < 3e-5 < MOST_MEDIAN_M
    assert figures.rarely_m < 6e-5
    assert figures.pixels == 4 * SIZE_PX[0] * SIZE_PX[1]
    assert figures.rays > figures.pixels / 40
    assert any("goal" in line for line in lines_of(figures))


def test_rays_are_cast_at_each_view_s_own_moment(moving):
    simulation, sequence = moving
    figures = ray_check(simulation, sequence, range(3, 6))
    assert figures.met
    assert np.all(figures.target_shares < MOST_WRONG)
    moved = np.linalg.norm([truth.velocities_mps[1] for truth in sequence.truths[3:6]], axis=1)
    assert moved.max() * 0.05 > 0.005  # so that another moment would show


def test_files_of_another_moment_do_not_agree(moving, tmp_path):
    simulation, sequence = moving
    copy = StoredSequence(tmp_path / "seq_000000", {})
    shutil.copytree(sequence.folder, copy.folder)
    for kind in ("seg_left", "depth_left"):
        shutil.copy(copy.folder / kind / "000002.png", copy.folder / kind / "000006.png")
    good, bad = (ray_check(simulation, one, [5]) for one in (sequence, copy))
    assert good.met
    assert not bad.met
    assert bad.target_shares.max() > 0.1


def test_a_share_of_wrong_pixels_is_counted_wherever_they_lie(moving, tmp_path):
    simulation, sequence = moving
    copy = StoredSequence(tmp_path / "seq_000000", {})
    shutil.copytree(sequence.folder, copy.folder)
    path = copy.folder / "seg_left" / "000001.png"
    seg = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    seg[10:58, 20:100] = 5  # a part of the wall, far from all targets
    path.write_bytes(encode.png(seg))
    figures = ray_check(simulation, copy, [0])
    assert figures.wrong_share == pytest.approx(48 * 80 / figures.pixels, rel=0.06)


def test_a_wrong_depth_is_measured(moving, tmp_path):
    simulation, sequence = moving
    copy = StoredSequence(tmp_path / "seq_000000", {})
    shutil.copytree(sequence.folder, copy.folder)
    for camera in ("left", "right"):
        path = copy.folder / f"depth_{camera}" / "000001.png"
        depth = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
        path.write_bytes(encode.png(depth + np.uint16(7)))
    figures = ray_check(simulation, copy, [0])
    assert figures.median_m == pytest.approx(7e-4, abs=2e-5)
    assert not figures.met


def test_figures_of_several_checks_are_those_of_one(moving):
    simulation, sequence = moving
    one = ray_check(simulation, sequence, [0, 4])
    both = pooled(ray_check(simulation, sequence, [index]) for index in (0, 4))
    for name in ("rays", "pixels", "wrong", "median_m", "rarely_m", "most_m"):
        assert getattr(one, name) == getattr(both, name)
    np.testing.assert_array_equal(one.target_wrong, both.target_wrong)
    assert pooled([]).met


def test_another_rig_and_unknown_frames_are_refused(moving, tmp_path):
    simulation, sequence = moving
    with pytest.raises(BenchError, match="has no frame 6"):
        ray_check(simulation, sequence, [6])
    copy = StoredSequence(tmp_path / "seq_000000", {})
    shutil.copytree(sequence.folder, copy.folder)
    record = json.loads((copy.folder / "rig.json").read_text())
    record["cameras"]["right"]["K"][0][0] += 1
    (copy.folder / "rig.json").write_text(json.dumps(record))
    with pytest.raises(BenchError, match=r"the right camera of rig\.json"):
        ray_check(simulation, copy, [0])
