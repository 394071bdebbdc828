"""WebDataset's shards, read by webdataset."""

import gc
import tarfile
import warnings

import cv2
import numpy as np
import pytest
import webdataset

import sim.dataset
from pjpdaf.errors import BenchError
from pjpdaf.targets import TARGETS
from sim.dataset.export.webdataset import exporter
from sim.dataset.files.cameras import camera_of
from sim.dataset.files.layout import LABELS
from sim.dataset.labels.records import SKELETONS
from sim.scene.world import CAMERAS


@pytest.fixture(scope="module")
def shards(dataset, tmp_path_factory):
    return exporter(shard_samples=6)(dataset, tmp_path_factory.mktemp("shards"))


def samples(shards):
    urls = [str(path) for path in shards]
    with warnings.catch_warnings():
        # webdataset leaves it to the garbage collector to close the last shard.
        warnings.filterwarnings("ignore", "unclosed file", ResourceWarning)
        read = list(webdataset.WebDataset(urls, shardshuffle=False).decode())
        gc.collect()
    return read


def decoded(data):
    return cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)


@pytest.fixture(scope="module")
def read(shards):
    return samples(shards)


def test_a_sample_is_a_frame_and_shards_are_no_longer_than_asked(dataset, shards, read):
    keys = [
        f"{sequence.name}_{index + 1:06d}"
        for sequence in dataset.sequences
        for index in range(sequence.frame_count)
    ]
    assert [sample["__key__"] for sample in read] == keys
    assert [path.name for path in shards] == [f"shard-{i:06d}.tar" for i in range(3)]
    for path, count in zip(shards, (6, 6, 3), strict=True):
        with tarfile.open(path) as tar:
            assert sum(name.endswith(".json") for name in tar.getnames()) == count


def test_members_are_the_files_of_the_data_set(dataset, read):
    sample = read[7]
    folders = (*CAMERAS, *(folder for folders in LABELS.values() for folder in folders))
    suffix = {folder: ".npz" if folder.startswith("float") else ".png" for folder in folders}
    members = {key for key in sample if not key.startswith("__")}
    wanted = {folder + suffix[folder] for folder in folders} | {"json"}
    assert members == wanted
    assert wanted - set(read[6]) == {f"flow_backward_{c}.png" for c in CAMERAS}  # the first frame
    assert wanted - set(read[9]) == {f"flow_forward_{c}.png" for c in CAMERAS}  # the last
    sequence = dataset.sequences[1]
    for folder in folders:
        if suffix[folder] == ".png":
            data = (sequence.folder / folder / "000002.png").read_bytes()
            assert sample[f"{folder}.png"] == data
    for name, array in sequence.floats(1, 1).items():
        np.testing.assert_array_equal(sample["float_right.npz"][name], array)
    depth_m = decoded(sample["depth_left.png"]) * 1e-4
    np.testing.assert_allclose(depth_m, np.nan_to_num(sequence.depth_m(0, 1)), atol=1e-6)


def test_the_json_has_truth_and_cameras_to_the_last_bit(dataset, read):
    samples = iter(read)
    for sequence in dataset.sequences:
        for truth in sequence.truths:
            said = next(samples)["json"]
            assert (said["sequence"], said["frame_index"]) == (sequence.name, truth.index)
            assert said["time_s"] == truth.time_s
            assert said["fps"] == sequence.fps
            assert [row["target"] for row in said["targets"]] == list(TARGETS)
            assert [row["skeleton"] for row in said["skeletons"]] == list(SKELETONS)
            joints = np.array(
                [list(p) for p in sequence.skeletons.iloc[3 * truth.index]["points_m"]]
            )
            np.testing.assert_array_equal(said["skeletons"][0]["points_m"], joints)
            centres = [[row[f"{axis}_m"] for axis in "xyz"] for row in said["targets"]]
            np.testing.assert_array_equal(centres, truth.centres_m)
            rigs = {"cameras": sequence.rig, "calibration": sequence.calibration}
            for key, rig in rigs.items():
                for camera, name in zip(rig.cameras, CAMERAS, strict=True):
                    np.testing.assert_array_equal(camera_of(said[key][name]).M, camera.M)
    assert next(samples, None) is None


def test_a_tar_has_no_times_owners_or_order_of_the_day(shards):
    for path in shards:
        with tarfile.open(path) as tar:
            members = tar.getmembers()
        assert [one.name for one in members] == sorted(one.name for one in members)
        for one in members:
            assert (one.mtime, one.uid, one.gid, one.uname, one.gname) == (0, 0, 0, "", "")
            assert one.mode == 0o644


def test_a_shard_is_no_larger_than_asked(dataset, tmp_path):
    most = 5 << 20
    shards = exporter(shard_bytes=most)(dataset, tmp_path)
    assert len(shards) > 3
    # A tar ends with empty blocks, to a whole record.
    assert all(path.stat().st_size <= most + tarfile.RECORDSIZE + 1024 for path in shards)
    assert len(samples(shards)) == 15


def test_a_link_out_of_the_data_set_is_no_picture(dataset_copy, tmp_path):
    secret = tmp_path / "000001.png"
    secret.write_bytes(b"\x89PNG\r\n\x1a\n of this machine")
    picture = dataset_copy / "seq_000000" / "left" / "000001.png"
    picture.unlink()
    picture.symlink_to(secret)
    with pytest.raises(BenchError, match=r"left/000001\.png: is a link"):
        exporter()(sim.dataset.open(dataset_copy), tmp_path)
