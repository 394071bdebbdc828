"""The tables of a sequence frame by frame, checked, as the exports need them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.compute as pc

from pjpdaf.errors import FileError
from pjpdaf.targets import TARGETS
from sim.dataset.files.layout import OBJECTS, RIG, TRUTH
from sim.dataset.files.reading import read_table
from sim.dataset.files.tables import OBJECTS_SCHEMA, TRUTH_SCHEMA
from sim.dataset.labels.records import KEYPOINTS, NOT_LABELLED, OCCLUDED, VISIBLE
from sim.dataset.stored_sequence import StoredSequence
from sim.scene.world import CAMERAS

FrameRow = Mapping[str, Any]
# What has no value where a target is not seen.
_MAY_LACK = ("u_", "v_", "box_", "amodal_box_", "surface_")


@dataclass(frozen=True, eq=False)
class FrameRows:
    """A frame's rows of truth.parquet, in the order of TARGETS, and of objects.parquet.

    arrived: by camera, whether its picture did.
    """

    index: int
    time_s: float
    stamp_s: float
    arrived: Mapping[str, bool]
    targets: tuple[FrameRow, ...]
    objects: tuple[FrameRow, ...]


def read_frame_rows(sequence: StoredSequence) -> list[FrameRows]:
    """All frames in order. Raises BenchError with the file's name where a table is damaged."""
    path = sequence.folder / TRUTH
    rows = _rows(path, TRUTH_SCHEMA)
    T, wanted = len(TARGETS), sequence.frame_count
    if len(rows) != T * wanted:
        raise FileError(path, f"must have {T * wanted} rows ({wanted} frames), has {len(rows)}")
    objects = _objects(sequence)
    frames = []
    for index in range(wanted):
        mine = tuple(rows[T * index : T * (index + 1)])
        if [(row["frame_index"], row["target"]) for row in mine] != [(index, t) for t in TARGETS]:
            raise FileError(
                path, f"frame {index}: must have the rows of {', '.join(TARGETS)}, in this order"
            )
        for t, row in enumerate(mine):
            if not _shaped(row, sum(target == t for target, _ in KEYPOINTS)):
                raise FileError(
                    path, f"frame {index}: {row['target']}: a box or keypoint is of the wrong size"
                )
        first = mine[0]
        frames.append(
            FrameRows(
                index,
                first["time_s"],
                first["stamp_s"],
                {camera: first[f"arrived_{camera}"] for camera in CAMERAS},
                mine,
                tuple(objects.get(index, ())),
            )
        )
    return frames


def object_kinds(sequence: StoredSequence) -> dict[str, str]:
    """Kind of each object by its name, e.g. a can."""
    listed = sequence.rig_json.get("objects")
    try:
        return {str(one["name"]): str(one["kind"]) for one in listed or ()}
    except (KeyError, TypeError) as fault:
        raise FileError(sequence.folder / RIG, "objects: is not a list of name, kind") from fault


def box_of(row: FrameRow, camera: str, prefix: str = "") -> list[float] | None:
    """x, y, width, height of a target's row in a view, None where nothing of it is visible.

    prefix: "amodal_" for the box with all other things removed.
    """
    values = [row[f"{prefix}box_{part}_{camera}_px"] for part in ("x", "y", "width", "height")]
    return None if None in values else values


def _objects(sequence: StoredSequence) -> dict[int, list[FrameRow]]:
    found: dict[int, list[FrameRow]] = {}
    for row in _rows(sequence.folder / OBJECTS, OBJECTS_SCHEMA):
        found.setdefault(row["frame_index"], []).append(row)
    return found


def _rows(path: Path, schema: pa.Schema) -> list[dict[str, Any]]:
    table = read_table(path, schema)
    for name in schema.names:
        column = table[name]
        if column.null_count and not name.startswith(_MAY_LACK):
            raise FileError(path, f"{name}: a value is missing")
        while pa.types.is_list(column.type):
            column = pc.list_flatten(column)
        # None where there are no numbers at all.
        if pa.types.is_floating(column.type) and pc.all(pc.is_finite(column)).as_py() is False:
            raise FileError(path, f"{name}: the numbers must be finite")
    return list(table.to_pylist())


def _shaped(row: FrameRow, keypoints: int) -> bool:
    """Whether a target's row has a box where it is visible, and keypoints of the right sizes."""
    if not _points(row["keypoints_m"], [OCCLUDED] * keypoints, 3):
        return False
    for camera in CAMERAS:
        status = row[f"keypoint_status_{camera}"]
        if len(status) != keypoints or not _points(row[f"keypoints_{camera}_px"], status, 2):
            return False
        if (row[f"visible_{camera}_px"] > 0) != (box_of(row, camera) is not None):
            return False
    return True


def _points(points: list[Any], status: list[int], size: int) -> bool:
    """Whether there is a point for each status, all numbers known but of those NOT_LABELLED."""
    return len(points) == len(status) and all(
        point is not None
        and len(point) == size
        and said in (NOT_LABELLED, OCCLUDED, VISIBLE)
        and (said == NOT_LABELLED or None not in point)
        for point, said in zip(points, status, strict=True)
    )
