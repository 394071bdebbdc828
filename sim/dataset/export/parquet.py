"""Parquet that Hugging Face's `datasets` loads without a script: a row per frame.

Both pictures are stored as PNG; the columns are those of `frame_columns`.
"""

from __future__ import annotations

import json
from collections.abc import Collection, Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

import pyarrow as pa

from sim.dataset.export.export import AddPart, Export, file_bytes
from sim.dataset.export.frame_columns import (
    CAMERA_PARTS,
    COLUMNS,
    FRAME_COLUMNS,
    INTEGER,
    TEXT,
    VIEW_COLUMNS,
    sequence_values,
)
from sim.dataset.export.parquet_files import ParquetFiles, RowStream
from sim.dataset.files.layout import picture_name
from sim.dataset.frame_rows import FrameRows, read_frame_rows
from sim.dataset.reader import Dataset
from sim.dataset.stored_sequence import StoredSequence
from sim.scene.world import CAMERAS
from sim.steps import counted

FILE_BYTES = 512 << 20
ROWS = "rows.arrows"  # of a part
_PICTURE = pa.struct([("bytes", pa.binary()), ("path", pa.string())])
_SCHEMA_COLUMNS: list[tuple[str, pa.DataType]] = [
    *((camera, _PICTURE) for camera in CAMERAS),
    ("sequence", TEXT),
    ("scenario", TEXT),
    ("group", TEXT),
    ("seed", INTEGER),
    *((name, kind) for name, kind, _ in FRAME_COLUMNS),
]
for _camera, _columns in VIEW_COLUMNS.items():
    _SCHEMA_COLUMNS += [(name, kind) for name, kind, _ in _columns]
    _SCHEMA_COLUMNS += [
        (f"{rig}_{part}_{_camera}", kind)
        for rig in ("camera", "calibration")
        for part, kind in CAMERA_PARTS.items()
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
            values = {name: value(frame) for name, _, value in COLUMNS}
            rows.add({**common, **_pictures(sequence, frame), **values})


def _common(sequence: StoredSequence) -> dict[str, Any]:
    """The columns that all frames of a sequence share."""
    row = sequence_values(sequence)
    for kind_, rig in (("camera", sequence.rig), ("calibration", sequence.calibration)):
        for name, camera in zip(CAMERAS, rig.cameras, strict=True):
            row |= {
                f"{kind_}_{part}_{name}": getattr(camera, part).tolist() for part in CAMERA_PARTS
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
