"""Parquet that Hugging Face's `datasets` loads without a script: a row a frame.

Both pictures lie in it as PNG. The lists over targets are in the order of TARGETS, those over
keypoints in the order of `records.KEYPOINTS`; a number that does not exist is NaN.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from pjpdaf.camera import Camera
from pjpdaf.errors import FileError
from pjpdaf.targets import TARGETS
from sim.dataset.export.folder import file_bytes, files_of, replaced_folder, sequences_of
from sim.dataset.files.layout import MANIFEST, picture_name
from sim.dataset.frame_rows import FrameRow, FrameRows, box_of, read_frame_rows
from sim.dataset.reader import Dataset
from sim.dataset.stored_sequence import StoredSequence
from sim.scene.world import CAMERAS

FOLDER = "parquet"
FILE_BYTES = 512 << 20
GROUP_ROWS, GROUP_BYTES = 100, 32 << 20  # of a row group, which is held in memory
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


def export(
    dataset: Dataset,
    into: Path,
    on_sequence: Callable[[str], None] = lambda name: None,
    *,
    most_bytes: int = FILE_BYTES,
) -> list[Path]:
    """Write `parquet/frames-00000-of-00001.parquet` and so on; see `registry.Export`.

    A file ends with the row group in which it comes to this many bytes.
    """
    folder = into / FOLDER
    with replaced_folder(folder, "the Parquet files") as part:
        with _Files(part, most_bytes) as files:
            for sequence in sequences_of(dataset):
                common = _common(dataset, sequence)
                for frame in read_frame_rows(sequence):
                    files.add({**common, **_pictures(sequence, frame), **_said(frame)})
                on_sequence(sequence.name)
        files.name()
    return files_of(folder)


def _common(dataset: Dataset, sequence: StoredSequence) -> dict[str, Any]:
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


def _said(frame: FrameRows) -> dict[str, Any]:
    targets, things = frame.targets, frame.objects
    row: dict[str, Any] = {
        "frame_index": frame.index,
        "time_s": frame.time_s,
        "stamp_s": frame.stamp_s,
        "events": targets[0]["events"],
        "positions_m": [_vector(one, "{}_m") for one in targets],
        "quaternions": [[one[q] for q in _QUATERNION] for one in targets],
        "velocities_mps": [_vector(one, "v{}_mps") for one in targets],
        "surfaces_m": [_vector(one, "surface_{}_m") for one in targets],
        "keypoints_m": [point for one in targets for point in one["keypoints_m"]],
        "objects": [one["object"] for one in things],
        "object_positions_m": [_vector(one, "{}_m") for one in things],
        "object_quaternions": [[one[q] for q in _QUATERNION] for one in things],
        "object_velocities_mps": [_vector(one, "v{}_mps") for one in things],
    }
    for camera in CAMERAS:
        hidden = [one[f"occluded_by_{camera}"] for one in targets]
        row |= {
            f"boxes_{camera}_px": [_box(one, camera, "") for one in targets],
            f"amodal_boxes_{camera}_px": [_box(one, camera, "amodal_") for one in targets],
            f"centroids_{camera}_px": [
                [_known(one[f"{axis}_{camera}_px"]) for axis in "uv"] for one in targets
            ],
            f"visible_{camera}_px": [one[f"visible_{camera}_px"] for one in targets],
            f"amodal_{camera}_px": [one[f"amodal_{camera}_px"] for one in targets],
            f"visible_fractions_{camera}": [one[f"visible_fraction_{camera}"] for one in targets],
            f"truncations_{camera}": [one[f"truncation_{camera}"] for one in targets],
            f"merged_{camera}": [
                [other in one[f"merged_with_{camera}"] for other in TARGETS] for one in targets
            ],
            f"occluders_{camera}": [[by["instance"] for by in one] for one in hidden],
            f"occluded_{camera}_px": [[by["pixels"] for by in one] for one in hidden],
            f"keypoints_{camera}_px": [
                [_known(value) for value in point]
                for one in targets
                for point in one[f"keypoints_{camera}_px"]
            ],
            f"keypoint_status_{camera}": [
                said for one in targets for said in one[f"keypoint_status_{camera}"]
            ],
            f"object_visible_{camera}_px": [one[f"visible_{camera}_px"] for one in things],
        }
    return row


def _vector(row: FrameRow, name: str) -> list[float]:
    return [_known(row[name.format(axis)]) for axis in "xyz"]


def _box(row: FrameRow, camera: str, prefix: str) -> list[float]:
    return box_of(row, camera, prefix) or [math.nan] * 4


def _known(value: float | None) -> float:
    return math.nan if value is None else value


class _Files:
    """Parquet files of row groups; how many there are is known, and said, at the end."""

    def __init__(self, folder: Path, most_bytes: int) -> None:
        self._folder, self._most_bytes = folder, most_bytes
        self._paths: list[Path] = []
        self._writer: pq.ParquetWriter | None = None
        self._rows: list[Mapping[str, Any]] = []
        self._held = self._written = 0

    def add(self, row: Mapping[str, Any]) -> None:
        """The next row."""
        self._rows.append(row)
        self._held += sum(len(row[c]["bytes"]) for c in CAMERAS if row[c] is not None)
        if len(self._rows) >= GROUP_ROWS or self._held >= min(GROUP_BYTES, self._most_bytes):
            self._write_group()

    def name(self) -> None:
        """Give the finished files their names."""
        for index, path in enumerate(self._paths):
            path.rename(path.with_name(f"frames-{index:05d}-of-{len(self._paths):05d}.parquet"))

    def _write_group(self) -> None:
        if self._writer is None:
            self._paths.append(self._folder / f"{len(self._paths)}.parquet")
            labels = [name for name in SCHEMA.names if name not in CAMERAS]
            self._writer = pq.ParquetWriter(
                self._paths[-1],
                SCHEMA,
                compression="zstd",
                # Pictures are neither alike nor to be compared.
                use_dictionary=labels,
                write_statistics=labels,
            )
            self._written = 0
        self._writer.write_table(pa.Table.from_pylist(self._rows, schema=SCHEMA))
        self._written += self._held
        self._rows, self._held = [], 0
        if self._written >= self._most_bytes:
            self._close()

    def _close(self) -> None:
        if self._writer is not None:
            self._writer.close()
            self._writer = None

    def __enter__(self) -> _Files:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if kind is None and self._rows:
            self._write_group()
        self._close()
