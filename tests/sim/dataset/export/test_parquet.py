"""Parquet for Hugging Face's `datasets`: what that library reads of a file, and the rows.

The library itself is not a part of the tests' environment. What it needs is written down in its
documentation: the key `huggingface` of the schema's metadata with {"info": {"features": ...}}, an
image as struct of bytes and path, and for every column an Arrow type that is the feature's own.
"""

import json
import math

import cv2
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

import sim.dataset
from pjpdaf.camera import Camera
from sim.dataset.export.parquet import exporter
from sim.dataset.labels.records import KEYPOINTS
from sim.scene.world import CAMERAS


@pytest.fixture(scope="module")
def files(dataset, tmp_path_factory):
    return exporter(1 << 20)(dataset, tmp_path_factory.mktemp("rows"))


@pytest.fixture(scope="module")
def rows(files):
    return [row for path in files for row in pq.read_table(path).to_pylist()]


def frames(dataset):
    return [(one, truth) for one in dataset.sequences for truth in one.truths]


def test_files_are_numbered_and_end_where_asked(files):
    count = len(files)
    assert 3 <= count <= 6
    assert [path.name for path in files] == [
        f"frames-{i:05d}-of-{count:05d}.parquet" for i in range(count)
    ]
    assert all(path.stat().st_size < 7 << 18 for path in files)


def arrow_type(feature):
    """The Arrow type that `datasets` gives a feature."""
    kind = feature["_type"]
    if kind == "Image":
        return pa.struct([("bytes", pa.binary()), ("path", pa.string())])
    if kind == "Sequence":
        return pa.list_(arrow_type(feature["feature"]))
    assert kind == "Value"
    return {
        "float64": pa.float64(),
        "int64": pa.int64(),
        "string": pa.string(),
        "bool": pa.bool_(),
    }[feature["dtype"]]


def test_the_metadata_describes_each_column_as_datasets_does(files):
    for path in files:
        schema = pq.read_schema(path)
        features = json.loads(schema.metadata[b"huggingface"])["info"]["features"]
        assert list(features) == schema.names
        for name, feature in features.items():
            assert schema.field(name).type == arrow_type(feature), name
        images = [name for name, feature in features.items() if feature["_type"] == "Image"]
        assert images == ["left", "right"]


def test_pictures_are_those_of_the_frames(dataset, rows):
    for row, (sequence, truth) in zip(rows, frames(dataset), strict=True):
        frame = sequence.frame(truth.index)
        for camera, picture in zip(CAMERAS, frame.pictures, strict=True):
            data = np.frombuffer(row[camera]["bytes"], np.uint8)
            np.testing.assert_array_equal(cv2.imdecode(data, cv2.IMREAD_COLOR), picture)
            assert (dataset.folder / row[camera]["path"]).is_file()


def test_labels_are_those_of_the_truth(dataset, rows):
    for row, (sequence, truth) in zip(rows, frames(dataset), strict=True):
        assert (row["sequence"], row["frame_index"]) == (sequence.name, truth.index)
        assert (row["scenario"], row["seed"]) == (
            sequence.entry["scenario"],
            sequence.entry["seed"],
        )
        assert (row["time_s"], row["events"]) == (truth.time_s, list(truth.events))
        np.testing.assert_array_equal(row["positions_m"], truth.centres_m)
        np.testing.assert_array_equal(row["velocities_mps"], truth.velocities_mps)
        np.testing.assert_array_equal(row["surfaces_m"], truth.surfaces_m)
        assert np.shape(row["keypoints_m"]) == (len(KEYPOINTS), 3)
        for camera, view in zip(CAMERAS, truth.views, strict=True):
            np.testing.assert_array_equal(row[f"boxes_{camera}_px"], view.boxes_px)
            np.testing.assert_array_equal(row[f"centroids_{camera}_px"], view.centroids_px)
            np.testing.assert_array_equal(row[f"visible_{camera}_px"], view.visible_px)
            np.testing.assert_array_equal(row[f"amodal_{camera}_px"], view.amodal_px)
            np.testing.assert_array_equal(row[f"merged_{camera}"], view.merged)
            assert np.shape(row[f"keypoints_{camera}_px"]) == (len(KEYPOINTS), 2)
            assert len(row[f"keypoint_status_{camera}"]) == len(KEYPOINTS)
            occluded = np.array([sum(one) for one in row[f"occluded_{camera}_px"]])
            np.testing.assert_array_equal(occluded, view.amodal_px - view.visible_px)


def test_joints_are_those_of_the_skeletons(dataset, rows):
    for row, (sequence, truth) in zip(rows, frames(dataset), strict=True):
        table = sequence.skeletons
        body, right, left = (table.iloc[3 * truth.index + k] for k in range(3))
        assert np.shape(row["hand_joints_m"]) == (42, 3)
        hands = np.array([list(p) for hand in (right, left) for p in hand["points_m"]])
        np.testing.assert_array_equal(row["hand_joints_m"], hands)
        angles = np.array([list(f) for hand in (right, left) for f in hand["finger_angles_rad"]])
        np.testing.assert_array_equal(row["finger_angles_rad"], angles)
        np.testing.assert_array_equal(row["body_points_m"], np.stack(body["points_m"]))
        for camera in CAMERAS:
            status = [*right[f"point_status_{camera}"], *left[f"point_status_{camera}"]]
            assert row[f"hand_joint_status_{camera}"] == status
            assert len(row[f"hand_joints_{camera}_px"]) == 42
            assert row[f"body_point_status_{camera}"] == list(body[f"point_status_{camera}"])


def test_objects_and_cameras_are_those_of_the_sequence(dataset, rows):
    for row, (sequence, truth) in zip(rows, frames(dataset), strict=True):
        table = sequence.objects
        mine = table[table["frame_index"] == truth.index]
        assert row["objects"] == mine["object"].tolist()
        places = mine[["x_m", "y_m", "z_m"]].to_numpy()
        np.testing.assert_array_equal(np.reshape(row["object_positions_m"], (-1, 3)), places)
        for kind, rig in (("camera", sequence.rig), ("calibration", sequence.calibration)):
            for name, camera in zip(CAMERAS, rig.cameras, strict=True):
                numbers = {
                    part: np.array(row[f"{kind}_{part}_{name}"])
                    for part in ("K", "R_cw", "t_cw", "distortion")
                }
                size = {"width_px": camera.width_px, "height_px": camera.height_px}
                np.testing.assert_array_equal(Camera(**numbers, **size).M, camera.M)
                np.testing.assert_array_equal(numbers["distortion"], camera.distortion)


def test_a_lost_picture_is_null_and_an_unseen_target_nan(dataset_copy, tmp_path):
    folder = dataset_copy / "seq_000002"
    (folder / "right" / "000003.png").unlink()
    path = folder / "truth.parquet"
    table = pq.read_table(path)
    said = table.to_pylist()
    for row in said:
        if row["frame_index"] == 2:
            row["arrived_right"] = False
    said[0]["visible_left_px"] = 0
    said[0] |= {f"box_{part}_left_px": None for part in ("x", "y", "width", "height")}
    pq.write_table(pa.Table.from_pylist(said, schema=table.schema), path)
    (file,) = exporter()(sim.dataset.open(dataset_copy), tmp_path)
    rows = [row for row in pq.read_table(file).to_pylist() if row["sequence"] == "seq_000002"]
    assert [row["right"] is None for row in rows] == [False, False, True, False, False]
    assert all(row["left"] is not None for row in rows)
    assert all(math.isnan(value) for value in rows[0]["boxes_left_px"][0])
    assert not any(math.isnan(value) for value in rows[0]["boxes_left_px"][1])
