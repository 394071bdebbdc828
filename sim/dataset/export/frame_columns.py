"""What exports with a row a frame have in common: the columns of the frame and of each view.

The lists over targets are in the order of TARGETS, those over keypoints in the order of
`records.KEYPOINTS`; a number that does not exist is NaN.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import pyarrow as pa

from pjpdaf.errors import FileError
from pjpdaf.targets import TARGETS
from sim.dataset.files.layout import MANIFEST
from sim.dataset.frame_rows import FrameRow, FrameRows, box_of
from sim.dataset.stored_sequence import StoredSequence
from sim.scene.world import CAMERAS

_QUATERNION = ("qw", "qx", "qy", "qz")
FLOAT, INTEGER, TEXT, BOOLEAN = pa.float64(), pa.int64(), pa.string(), pa.bool_()
VECTOR, NUMBERS, TEXTS = pa.list_(FLOAT), pa.list_(INTEGER), pa.list_(TEXT)
TABLE = pa.list_(VECTOR)


def _vector(row: FrameRow, name: str) -> list[float]:
    return [_number(row[name.format(axis)]) for axis in "xyz"]


def _box(row: FrameRow, camera: str, prefix: str) -> list[float]:
    return box_of(row, camera, prefix) or [math.nan] * 4


def _number(value: float | None) -> float:
    return math.nan if value is None else value


def _targets(value: Callable[[FrameRow], Any]) -> Callable[[FrameRows], list[Any]]:
    """A list over the targets of a frame."""
    return lambda frame: [value(row) for row in frame.targets]


def _keypoints(name: str, value: Callable[[Any], Any]) -> Callable[[FrameRows], list[Any]]:
    """A list over the keypoints of all targets of a frame."""
    return lambda frame: [value(entry) for row in frame.targets for entry in row[name]]


def _hands(name: str, value: Callable[[Any], Any]) -> Callable[[FrameRows], list[Any]]:
    """A list over the joints, or the fingers, of the right hand, then of the left."""
    return lambda frame: [value(entry) for row in frame.skeletons[1:] for entry in row[name]]


def _body(name: str, value: Callable[[Any], Any]) -> Callable[[FrameRows], list[Any]]:
    """A list over the points of the body."""
    return lambda frame: [value(entry) for entry in frame.skeletons[0][name]]


def _point(numbers: list[float | None]) -> list[float]:
    return [_number(value) for value in numbers]


def _objects(value: Callable[[FrameRow], Any]) -> Callable[[FrameRows], list[Any]]:
    """A list over the objects of a frame."""
    return lambda frame: [value(row) for row in frame.objects]


Column = tuple[str, pa.DataType, Callable[[FrameRows], Any]]  # name, type, value of a frame
FRAME_COLUMNS: list[Column] = [
    ("frame_index", INTEGER, lambda frame: frame.index),
    ("time_s", FLOAT, lambda frame: frame.time_s),
    ("stamp_s", FLOAT, lambda frame: frame.stamp_s),
    ("events", TEXTS, lambda frame: frame.targets[0]["events"]),
    ("positions_m", TABLE, _targets(lambda row: _vector(row, "{}_m"))),
    ("quaternions", TABLE, _targets(lambda row: [row[q] for q in _QUATERNION])),
    ("velocities_mps", TABLE, _targets(lambda row: _vector(row, "v{}_mps"))),
    ("surfaces_m", TABLE, _targets(lambda row: _vector(row, "surface_{}_m"))),
    ("keypoints_m", TABLE, _keypoints("keypoints_m", lambda point: point)),
    ("hand_joints_m", TABLE, _hands("points_m", list)),
    ("finger_angles_rad", TABLE, _hands("finger_angles_rad", list)),
    ("body_points_m", TABLE, _body("points_m", list)),
    ("objects", TEXTS, _objects(lambda row: row["object"])),
    ("object_positions_m", TABLE, _objects(lambda row: _vector(row, "{}_m"))),
    ("object_quaternions", TABLE, _objects(lambda row: [row[q] for q in _QUATERNION])),
    ("object_velocities_mps", TABLE, _objects(lambda row: _vector(row, "v{}_mps"))),
]


def _view_columns(c: str) -> list[Column]:
    """The columns of a camera's view."""

    def occluders(row: FrameRow, key: str) -> list[Any]:
        return [by[key] for by in row[f"occluded_by_{c}"]]

    def centroid(row: FrameRow) -> list[float]:
        return [_number(row[f"{axis}_{c}_px"]) for axis in "uv"]

    def merged(row: FrameRow) -> list[bool]:
        return [other in row[f"merged_with_{c}"] for other in TARGETS]

    points, status = f"keypoints_{c}_px", f"keypoint_status_{c}"
    return [
        (f"boxes_{c}_px", TABLE, _targets(lambda row: _box(row, c, ""))),
        (f"amodal_boxes_{c}_px", TABLE, _targets(lambda row: _box(row, c, "amodal_"))),
        (f"centroids_{c}_px", TABLE, _targets(centroid)),
        (f"visible_{c}_px", NUMBERS, _targets(lambda row: row[f"visible_{c}_px"])),
        (f"amodal_{c}_px", NUMBERS, _targets(lambda row: row[f"amodal_{c}_px"])),
        (f"visible_fractions_{c}", VECTOR, _targets(lambda row: row[f"visible_fraction_{c}"])),
        (f"truncations_{c}", VECTOR, _targets(lambda row: row[f"truncation_{c}"])),
        (f"merged_{c}", pa.list_(pa.list_(BOOLEAN)), _targets(merged)),
        (f"occluders_{c}", pa.list_(TEXTS), _targets(lambda row: occluders(row, "instance"))),
        (f"occluded_{c}_px", pa.list_(NUMBERS), _targets(lambda row: occluders(row, "pixels"))),
        (points, TABLE, _keypoints(points, _point)),
        (status, NUMBERS, _keypoints(status, int)),
        (f"hand_joints_{c}_px", TABLE, _hands(f"points_{c}_px", _point)),
        (f"hand_joint_status_{c}", NUMBERS, _hands(f"point_status_{c}", int)),
        (f"body_points_{c}_px", TABLE, _body(f"points_{c}_px", _point)),
        (f"body_point_status_{c}", NUMBERS, _body(f"point_status_{c}", int)),
        (f"object_visible_{c}_px", NUMBERS, _objects(lambda row: row[f"visible_{c}_px"])),
    ]


VIEW_COLUMNS = {camera: _view_columns(camera) for camera in CAMERAS}
COLUMNS = [*FRAME_COLUMNS, *(column for view in VIEW_COLUMNS.values() for column in view)]
# Of a camera, with the type of a column.
CAMERA_PARTS = {"K": TABLE, "R_cw": TABLE, "t_cw": VECTOR, "distortion": VECTOR}


def sequence_values(sequence: StoredSequence) -> dict[str, Any]:
    """Name, scenario, group and seed of a sequence. Raises FileError for a damaged manifest."""
    values: dict[str, Any] = {"sequence": sequence.name}
    for key, kind in {"scenario": str, "group": str, "seed": int}.items():
        values[key] = sequence.entry.get(key)
        if not isinstance(values[key], kind):
            path = sequence.folder.parent / MANIFEST
            raise FileError(path, f"sequences: {sequence.name}: {key} must be {kind.__name__}")
    return values
