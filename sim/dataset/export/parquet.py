"""Parquet that Hugging Face's `datasets` loads without a script: a row per frame.

Both pictures are stored as PNG. The lists over targets are in the order of TARGETS, those over
keypoints in the order of `records.KEYPOINTS`; a number that does not exist is NaN.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

import pyarrow as pa

from pjpdaf.camera import Camera
from pjpdaf.errors import FileError
from pjpdaf.targets import TARGETS
from sim.dataset.export.export import AddSequence, Export, file_bytes
from sim.dataset.export.parquet_files import ParquetFiles
from sim.dataset.files.layout import MANIFEST, picture_name
from sim.dataset.frame_rows import FrameRow, FrameRows, box_of, read_frame_rows
from sim.dataset.reader import Dataset
from sim.dataset.stored_sequence import StoredSequence
from sim.scene.world import CAMERAS

FILE_BYTES = 512 << 20
_QUATERNION = ("qw", "qx", "qy", "qz")
_PICTURE = pa.struct([("bytes", pa.binary()), ("path", pa.string())])
_F, _I, _S, _B = pa.float64(), pa.int64(), pa.string(), pa.bool_()
_VECTOR, _NUMBERS, _TEXTS = pa.list_(_F), pa.list_(_I), pa.list_(_S)
_TABLE = pa.list_(_VECTOR)


def _view_columns(camera: str) -> list[tuple[str, pa.DataType]]:
    return [
        (f"boxes_{camera}_px", _TABLE),
        (f"amodal_boxes_{camera}_px", _TABLE),
        (f"centroids_{camera}_px", _TABLE),
        (f"visible_{camera}_px", _NUMBERS),
        (f"amodal_{camera}_px", _NUMBERS),
        (f"visible_fractions_{camera}", _VECTOR),
        (f"truncations_{camera}", _VECTOR),
        (f"merged_{camera}", pa.list_(pa.list_(_B))),
        (f"occluders_{camera}", pa.list_(_TEXTS)),
        (f"occluded_{camera}_px", pa.list_(_NUMBERS)),
        (f"keypoints_{camera}_px", _TABLE),
        (f"keypoint_status_{camera}", _NUMBERS),
        (f"object_visible_{camera}_px", _NUMBERS),
        *(
            (f"{kind}_{name}_{camera}", _VECTOR if name in ("t_cw", "distortion") else _TABLE)
            for kind in ("camera", "calibration")
            for name in ("K", "R_cw", "t_cw", "distortion")
        ),
    ]


_COLUMNS: list[tuple[str, pa.DataType]] = [
    *((camera, _PICTURE) for camera in CAMERAS),
    ("sequence", _S),
    ("scenario", _S),
    ("group", _S),
    ("seed", _I),
    ("frame_index", _I),
    ("time_s", _F),
    ("stamp_s", _F),
    ("events", _TEXTS),
    ("positions_m", _TABLE),
    ("quaternions", _TABLE),
    ("velocities_mps", _TABLE),
    ("surfaces_m", _TABLE),
    ("keypoints_m", _TABLE),
    ("objects", _TEXTS),
    ("object_positions_m", _TABLE),
    ("object_quaternions", _TABLE),
    ("object_velocities_mps", _TABLE),
    *(column for camera in CAMERAS for column in _view_columns(camera)),
]


def _feature(kind: pa.DataType) -> dict[str, Any]:
    """A column as `datasets` describes it, in the form that its versions before 4 read, too."""
    if kind == _PICTURE:
        return {"_type": "Image"}
    if pa.types.is_list(kind):
        return {"feature": _feature(kind.value_type), "_type": "Sequence"}
    return {"dtype": {"double": "float64"}.get(str(kind), str(kind)), "_type": "Value"}


_FEATURES = {name: _feature(kind) for name, kind in _COLUMNS}
SCHEMA = pa.schema(_COLUMNS).with_metadata(
    {"huggingface": json.dumps({"info": {"features": _FEATURES}})}
)


def exporter(most_bytes: int = FILE_BYTES) -> Export:
    """The export to `parquet/frames-00000-of-00001.parquet` and so on.

    A file ends with the row group in which it reaches most_bytes.
    """

    @contextmanager
    def write_parquet(dataset: Dataset, folder: Path) -> Iterator[AddSequence]:
        def add(sequence: StoredSequence) -> None:
            common = _common(dataset, sequence)
            for frame in read_frame_rows(sequence):
                files.add({**common, **_pictures(sequence, frame), **_frame_columns(frame)})

        with closing(ParquetFiles(folder, SCHEMA, most_bytes)) as files:
            yield add
            files.finish()

    return Export("parquet", "the Parquet files", write_parquet)


def _common(dataset: Dataset, sequence: StoredSequence) -> dict[str, Any]:
    """The columns that all frames of a sequence share."""
    entry = sequence.entry
    row: dict[str, Any] = {"sequence": sequence.name}
    for key, kind in {"scenario": str, "group": str, "seed": int}.items():
        row[key] = entry.get(key)
        if not isinstance(row[key], kind):
            path = dataset.folder / MANIFEST
            raise FileError(path, f"sequences: {sequence.name}: {key} must be {kind.__name__}")
    for kind_, rig in (("camera", sequence.rig), ("calibration", sequence.calibration)):
        for name, camera in zip(CAMERAS, rig.cameras, strict=True):
            row |= {f"{kind_}_{part}_{name}": value for part, value in _numbers(camera).items()}
    return row


def _numbers(camera: Camera) -> dict[str, Any]:
    return {name: getattr(camera, name).tolist() for name in ("K", "R_cw", "t_cw", "distortion")}


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


def _frame_columns(frame: FrameRows) -> dict[str, Any]:
    """The columns that the frame's rows of the tables give."""
    targets, objects = frame.targets, frame.objects
    columns: dict[str, Any] = {
        "frame_index": frame.index,
        "time_s": frame.time_s,
        "stamp_s": frame.stamp_s,
        "events": targets[0]["events"],
        "positions_m": [_vector(row, "{}_m") for row in targets],
        "quaternions": [[row[q] for q in _QUATERNION] for row in targets],
        "velocities_mps": [_vector(row, "v{}_mps") for row in targets],
        "surfaces_m": [_vector(row, "surface_{}_m") for row in targets],
        "keypoints_m": [point for row in targets for point in row["keypoints_m"]],
        "objects": [row["object"] for row in objects],
        "object_positions_m": [_vector(row, "{}_m") for row in objects],
        "object_quaternions": [[row[q] for q in _QUATERNION] for row in objects],
        "object_velocities_mps": [_vector(row, "v{}_mps") for row in objects],
    }
    for camera in CAMERAS:
        occluders = [row[f"occluded_by_{camera}"] for row in targets]
        columns |= {
            f"boxes_{camera}_px": [_box(row, camera, "") for row in targets],
            f"amodal_boxes_{camera}_px": [_box(row, camera, "amodal_") for row in targets],
            f"centroids_{camera}_px": [
                [_known(row[f"{axis}_{camera}_px"]) for axis in "uv"] for row in targets
            ],
            f"visible_{camera}_px": [row[f"visible_{camera}_px"] for row in targets],
            f"amodal_{camera}_px": [row[f"amodal_{camera}_px"] for row in targets],
            f"visible_fractions_{camera}": [row[f"visible_fraction_{camera}"] for row in targets],
            f"truncations_{camera}": [row[f"truncation_{camera}"] for row in targets],
            f"merged_{camera}": [
                [other in row[f"merged_with_{camera}"] for other in TARGETS] for row in targets
            ],
            f"occluders_{camera}": [[by["instance"] for by in listed] for listed in occluders],
            f"occluded_{camera}_px": [[by["pixels"] for by in listed] for listed in occluders],
            f"keypoints_{camera}_px": [
                [_known(value) for value in point]
                for row in targets
                for point in row[f"keypoints_{camera}_px"]
            ],
            f"keypoint_status_{camera}": [
                status for row in targets for status in row[f"keypoint_status_{camera}"]
            ],
            f"object_visible_{camera}_px": [row[f"visible_{camera}_px"] for row in objects],
        }
    return columns


def _vector(row: FrameRow, name: str) -> list[float]:
    return [_known(row[name.format(axis)]) for axis in "xyz"]


def _box(row: FrameRow, camera: str, prefix: str) -> list[float]:
    return box_of(row, camera, prefix) or [math.nan] * 4


def _known(value: float | None) -> float:
    return math.nan if value is None else value
