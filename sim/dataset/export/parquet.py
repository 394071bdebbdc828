"""Parquet that Hugging Face's `datasets` loads without a script: a row per frame.

Both pictures are stored as PNG. The lists over targets are in the order of TARGETS, those over
keypoints in the order of `records.KEYPOINTS`; a number that does not exist is NaN.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Collection, Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

import pyarrow as pa

from pjpdaf.errors import FileError
from pjpdaf.targets import TARGETS
from sim.dataset.export.export import AddPart, Export, file_bytes
from sim.dataset.export.parquet_files import ParquetFiles, RowStream
from sim.dataset.files.layout import MANIFEST, picture_name
from sim.dataset.frame_rows import FrameRow, FrameRows, box_of, read_frame_rows
from sim.dataset.reader import Dataset
from sim.dataset.stored_sequence import StoredSequence
from sim.scene.world import CAMERAS
from sim.steps import counted

FILE_BYTES = 512 << 20
ROWS = "rows.arrows"  # of a part
_QUATERNION = ("qw", "qx", "qy", "qz")
_PICTURE = pa.struct([("bytes", pa.binary()), ("path", pa.string())])
_F, _I, _S, _B = pa.float64(), pa.int64(), pa.string(), pa.bool_()
_VECTOR, _NUMBERS, _TEXTS = pa.list_(_F), pa.list_(_I), pa.list_(_S)
_TABLE = pa.list_(_VECTOR)


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
_FRAME_COLUMNS: list[Column] = [
    ("frame_index", _I, lambda frame: frame.index),
    ("time_s", _F, lambda frame: frame.time_s),
    ("stamp_s", _F, lambda frame: frame.stamp_s),
    ("events", _TEXTS, lambda frame: frame.targets[0]["events"]),
    ("positions_m", _TABLE, _targets(lambda row: _vector(row, "{}_m"))),
    ("quaternions", _TABLE, _targets(lambda row: [row[q] for q in _QUATERNION])),
    ("velocities_mps", _TABLE, _targets(lambda row: _vector(row, "v{}_mps"))),
    ("surfaces_m", _TABLE, _targets(lambda row: _vector(row, "surface_{}_m"))),
    ("keypoints_m", _TABLE, _keypoints("keypoints_m", lambda point: point)),
    ("hand_joints_m", _TABLE, _hands("points_m", list)),
    ("finger_angles_rad", _TABLE, _hands("finger_angles_rad", list)),
    ("body_points_m", _TABLE, _body("points_m", list)),
    ("objects", _TEXTS, _objects(lambda row: row["object"])),
    ("object_positions_m", _TABLE, _objects(lambda row: _vector(row, "{}_m"))),
    ("object_quaternions", _TABLE, _objects(lambda row: [row[q] for q in _QUATERNION])),
    ("object_velocities_mps", _TABLE, _objects(lambda row: _vector(row, "v{}_mps"))),
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
        (f"boxes_{c}_px", _TABLE, _targets(lambda row: _box(row, c, ""))),
        (f"amodal_boxes_{c}_px", _TABLE, _targets(lambda row: _box(row, c, "amodal_"))),
        (f"centroids_{c}_px", _TABLE, _targets(centroid)),
        (f"visible_{c}_px", _NUMBERS, _targets(lambda row: row[f"visible_{c}_px"])),
        (f"amodal_{c}_px", _NUMBERS, _targets(lambda row: row[f"amodal_{c}_px"])),
        (f"visible_fractions_{c}", _VECTOR, _targets(lambda row: row[f"visible_fraction_{c}"])),
        (f"truncations_{c}", _VECTOR, _targets(lambda row: row[f"truncation_{c}"])),
        (f"merged_{c}", pa.list_(pa.list_(_B)), _targets(merged)),
        (f"occluders_{c}", pa.list_(_TEXTS), _targets(lambda row: occluders(row, "instance"))),
        (f"occluded_{c}_px", pa.list_(_NUMBERS), _targets(lambda row: occluders(row, "pixels"))),
        (points, _TABLE, _keypoints(points, _point)),
        (status, _NUMBERS, _keypoints(status, int)),
        (f"hand_joints_{c}_px", _TABLE, _hands(f"points_{c}_px", _point)),
        (f"hand_joint_status_{c}", _NUMBERS, _hands(f"point_status_{c}", int)),
        (f"body_points_{c}_px", _TABLE, _body(f"points_{c}_px", _point)),
        (f"body_point_status_{c}", _NUMBERS, _body(f"point_status_{c}", int)),
        (f"object_visible_{c}_px", _NUMBERS, _objects(lambda row: row[f"visible_{c}_px"])),
    ]


_VIEW_COLUMNS = {camera: _view_columns(camera) for camera in CAMERAS}
_CAMERA_PARTS = {"K": _TABLE, "R_cw": _TABLE, "t_cw": _VECTOR, "distortion": _VECTOR}
_SCHEMA_COLUMNS: list[tuple[str, pa.DataType]] = [
    *((camera, _PICTURE) for camera in CAMERAS),
    ("sequence", _S),
    ("scenario", _S),
    ("group", _S),
    ("seed", _I),
    *((name, kind) for name, kind, _ in _FRAME_COLUMNS),
]
for _camera, _columns in _VIEW_COLUMNS.items():
    _SCHEMA_COLUMNS += [(name, kind) for name, kind, _ in _columns]
    _SCHEMA_COLUMNS += [
        (f"{rig}_{part}_{_camera}", kind)
        for rig in ("camera", "calibration")
        for part, kind in _CAMERA_PARTS.items()
    ]


def _feature(kind: pa.DataType) -> dict[str, Any]:
    """A column as `datasets` describes it, in the form that its versions before 4 read, too."""
    if kind == _PICTURE:
        return {"_type": "Image"}
    if pa.types.is_list(kind):
        return {"feature": _feature(kind.value_type), "_type": "Sequence"}
    return {"dtype": {"double": "float64"}.get(str(kind), str(kind)), "_type": "Value"}


_FEATURES = {name: _feature(kind) for name, kind in _SCHEMA_COLUMNS}
SCHEMA = pa.schema(_SCHEMA_COLUMNS).with_metadata(
    {"huggingface": json.dumps({"info": {"features": _FEATURES}})}
)


_COLUMNS = [*_FRAME_COLUMNS, *(column for view in _VIEW_COLUMNS.values() for column in view)]


def exporter(most_bytes: int = FILE_BYTES) -> Export:
    """The export to `parquet/frames-00000-of-00001.parquet` and so on.

    A file ends with the row group in which it reaches most_bytes.
    """

    @contextmanager
    def joining(dataset: Dataset, folder: Path) -> Iterator[AddPart]:
        with closing(ParquetFiles(folder, SCHEMA, most_bytes)) as files:
            yield lambda sequence, part: files.add(part / ROWS)
            files.finish()

    return Export("parquet", "parquet", "the Parquet files", write_rows, joining)


def write_rows(sequence: StoredSequence, labels: Collection[str], part: Path) -> None:
    """Write the rows of a sequence as an Arrow stream."""
    common = _common(sequence)
    with RowStream(part / ROWS, SCHEMA) as rows:
        for frame in counted(read_frame_rows(sequence)):
            values = {name: value(frame) for name, _, value in _COLUMNS}
            rows.add({**common, **_pictures(sequence, frame), **values})


def _common(sequence: StoredSequence) -> dict[str, Any]:
    """The columns that all frames of a sequence share."""
    entry = sequence.entry
    row: dict[str, Any] = {"sequence": sequence.name}
    for key, kind in {"scenario": str, "group": str, "seed": int}.items():
        row[key] = entry.get(key)
        if not isinstance(row[key], kind):
            path = sequence.folder.parent / MANIFEST
            raise FileError(path, f"sequences: {sequence.name}: {key} must be {kind.__name__}")
    for kind_, rig in (("camera", sequence.rig), ("calibration", sequence.calibration)):
        for name, camera in zip(CAMERAS, rig.cameras, strict=True):
            row |= {
                f"{kind_}_{part}_{name}": getattr(camera, part).tolist() for part in _CAMERA_PARTS
            }
    return row


def _pictures(sequence: StoredSequence, frame: FrameRows) -> dict[str, Any]:
    row: dict[str, Any] = {}
    for camera in CAMERAS:
        path = f"{camera}/{picture_name(frame.index)}"
        row[camera] = (
            {"bytes": file_bytes(sequence.folder / path), "path": f"{sequence.name}/{path}"}
            if frame.arrived[camera]
            else None
        )
    return row
