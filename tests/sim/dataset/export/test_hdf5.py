"""HDF5 files, read by h5py."""

import shutil
import sys

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

import sim.dataset
from pjpdaf.errors import BenchError
from pjpdaf.targets import TARGETS
from sim.dataset.export.hdf5 import export
from sim.dataset.files.cameras import camera_of
from sim.dataset.files.layout import LABELS, frames_with
from sim.dataset.labels.records import NO_SURFACE
from sim.scene.world import CAMERAS

h5py = pytest.importorskip("h5py")


@pytest.fixture(scope="module")
def eventful(dataset_made, tmp_path_factory):
    """A copy in which a sequence has events and has lost a picture."""
    copy = tmp_path_factory.mktemp("hdf5") / "copy"
    shutil.copytree(dataset_made, copy)
    (copy / "seq_000002" / "right" / "000003.png").unlink()
    path = copy / "seq_000002" / "truth.parquet"
    table = pq.read_table(path)
    rows = table.to_pylist()
    for row in rows:
        row["arrived_right"] = row["frame_index"] != 2
        row["events"] = [[], ["waves"], ["lifts", "waves"]][min(row["frame_index"], 2)]
    pq.write_table(pa.Table.from_pylist(rows, schema=table.schema), path)
    return sim.dataset.open(copy)


@pytest.fixture(scope="module")
def files(eventful, tmp_path_factory):
    """The open file of each sequence."""
    dataset = eventful
    paths = export(dataset, tmp_path_factory.mktemp("hdf5"))
    assert [path.name for path in paths] == [f"{one.name}.h5" for one in dataset.sequences]
    opened = [h5py.File(path) for path in paths]
    yield list(zip(opened, dataset.sequences, strict=True))
    for file in opened:
        file.close()


def scaled(array, index):
    """The values of an array, by the rule that its attributes give."""
    return (array[index] - float(array.attrs["zero"])) * array.attrs["scale"]


def test_pictures_are_those_of_the_frames_in_rgb(files):
    for file, sequence in files:
        for frame, _ in sequence.frames():
            arrived = file["truth/arrived"][frame.index]
            for v, picture in enumerate(frame.pictures):
                own = file[f"pictures/{CAMERAS[v]}"][frame.index]
                assert arrived[v] == (picture is not None)
                np.testing.assert_array_equal(own, 0 if picture is None else picture[..., ::-1])
        for frame in sequence.background():
            for v, picture in enumerate(frame.pictures):
                own = file[f"pictures/background_{CAMERAS[v]}"][frame.index]
                np.testing.assert_array_equal(own, picture[..., ::-1])
    assert not all(file["truth/arrived"][...].all() for file, _ in files)


@pytest.mark.long
def test_labels_are_those_of_the_data_set(files):
    for file, sequence in files:
        named = {folder for folders in LABELS.values() for folder in folders}
        assert set(file["labels"]) == named
        for index in range(sequence.frame_count):
            for v, camera in enumerate(CAMERAS):
                label = {name: file[f"labels/{name}_{camera}"] for name in ("seg", "semantic")}
                np.testing.assert_array_equal(label["seg"][index], sequence.seg(v, index))
                np.testing.assert_array_equal(label["semantic"][index], sequence.classes(v, index))
                depth = scaled(file[f"labels/depth_{camera}"], index)
                np.testing.assert_allclose(
                    depth, np.nan_to_num(sequence.depth_m(v, index)), atol=1e-6
                )
                normals = sequence.normals(v, index)
                known = np.isfinite(normals).all(axis=-1)
                own = scaled(file[f"labels/normals_{camera}"], index)[known]
                np.testing.assert_allclose(own, normals[known], atol=1 / 127)
                for name, array in sequence.floats(v, index).items():
                    own = file[f"labels/float_{camera}/{name}"][index]
                    np.testing.assert_array_equal(own, array)


def test_flow_moves_a_pixel_as_the_data_sets_does_and_is_zeros_without_a_frame_to_go_to(files):
    for file, sequence in files:
        count = sequence.frame_count
        for direction in ("forward", "backward"):
            folder = f"flow_{direction}_right"
            array = file[f"labels/{folder}"]
            for index in range(count):
                if index not in frames_with(folder, count):
                    assert not array[index].any()
                    continue
                flow = sequence.flow(1, index, direction)
                assert flow.places_px is not None
                np.testing.assert_array_equal(array[index][..., 2], flow.status)
                ys, xs = np.nonzero(flow.status != NO_SURFACE)
                moved = scaled(array, index)[ys, xs, :2]
                to = flow.places_px[ys, xs] - np.stack([xs, ys], axis=-1)
                np.testing.assert_allclose(moved, to, atol=1e-4)


def test_truth_is_that_of_the_tables(files):
    for file, sequence in files:
        truth = file["truth"]
        assert list(truth["targets"].asstr()) == list(TARGETS)
        truths = sequence.truths
        np.testing.assert_array_equal(truth["time_s"], [one.time_s for one in truths])
        np.testing.assert_array_equal(truth["positions_m"], [one.centres_m for one in truths])
        events = list(truth["events"].asstr()) if "events" in truth else []
        for one, shown in zip(truths, truth["events_of_frames"], strict=True):
            assert {name for name, is_on in zip(events, shown, strict=True) if is_on} == {
                *one.events
            }
        for v, camera in enumerate(CAMERAS):
            views = [one.views[v] for one in truths]
            np.testing.assert_array_equal(
                truth[f"boxes_{camera}_px"], [view.boxes_px for view in views]
            )
            np.testing.assert_array_equal(
                truth[f"merged_{camera}"], [view.merged for view in views]
            )
            hidden = [view.amodal_px - view.visible_px for view in views]
            np.testing.assert_array_equal(truth[f"occluded_{camera}_px"][...].sum(axis=2), hidden)
        # Occluders by their names.
        names = list(truth["instances"].asstr())
        ids = {one.name: one.id for one in sequence.instances} | {"nothing": 0}
        assert [ids[name] for name in names] == truth["instance_ids"][...].tolist()
        rows = sequence.truth[sequence.truth["target"] == "right_hand"]
        for index, listed in enumerate(rows["occluded_by_left"]):
            own = truth["occluded_left_px"][index, 1]
            assert {n: px for n, px in zip(names, own, strict=True) if px} == {
                by["instance"]: by["pixels"] for by in listed
            }
        joints = np.array(
            [list(p) for p in sequence.skeletons["points_m"].iloc[1::3]]  # the right hand
        )
        np.testing.assert_array_equal(truth["hand_joints_m"][:, :21], joints)
        assert truth["finger_angles_rad"].shape == (sequence.frame_count, 10, 3)
    assert any("events" in file["truth"] for file, _ in files)


def test_objects_and_cameras_are_those_of_the_sequence(files):
    for file, sequence in files:
        table = sequence.objects
        names = list(file["truth/objects"].asstr()) if len(table) else []
        assert sorted(set(table["object"])) == sorted(names)
        if names:
            places = table[["x_m", "y_m", "z_m"]].to_numpy().reshape(-1, len(names), 3)
            np.testing.assert_array_equal(file["truth/object_positions_m"], places)
        for kind, rig in (("cameras", sequence.rig), ("calibration", sequence.calibration)):
            for name, camera in zip(CAMERAS, rig.cameras, strict=True):
                parts = {key: array[...] for key, array in file[f"{kind}/{name}"].items()}
                size = {"width_px": camera.width_px, "height_px": camera.height_px}
                np.testing.assert_array_equal(camera_of({**parts, **size}).M, camera.M)
        assert file.attrs["fps"] == sequence.fps
        assert file.attrs["scenario"] == sequence.entry["scenario"]


def test_without_the_library_one_line_says_what_to_install(dataset, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "h5py", None)
    with pytest.raises(BenchError, match=r"the HDF5 files need h5py.*pjpdaf-bench\[dataset\]"):
        export(sim.dataset.open(dataset.folder), tmp_path)
    assert not list(tmp_path.iterdir())
