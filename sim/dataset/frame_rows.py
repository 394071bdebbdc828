"""The rows of a sequence's tables by frame, checked."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.compute as pc

from pjpdaf.errors import FileError
from pjpdaf.targets import TARGETS
from sim.dataset.files.layout import OBJECTS, RIG, SKELETON, TRUTH
from sim.dataset.files.reading import read_table
from sim.dataset.files.tables import OBJECTS_SCHEMA, SKELETON_SCHEMA, TRUTH_SCHEMA
from sim.dataset.labels.records import (
    HAND_SKELETONS,
    KEYPOINTS,
    NOT_LABELLED,
    OCCLUDED,
    SKELETONS,
    VISIBLE,
)
from sim.dataset.stored_sequence import StoredSequence
from sim.scene.world import CAMERAS

FrameRow = Mapping[str, Any]
# Columns without a value where a target is not visible.
_MAY_LACK = ("u_", "v_", "box_", "amodal_box_", "surface_")


@dataclass(frozen=True, eq=False)
class FrameRows:
    """A frame's rows of truth.parquet, in the order of TARGETS, of objects.parquet, and of
    skeletons.parquet, in the order of SKELETONS.

    arrived: by camera, whether its picture arrived.
    """

    index: int
    time_s: float
    stamp_s: float
    arrived: Mapping[str, bool]
    targets: tuple[FrameRow, ...]
    objects: tuple[FrameRow, ...]
    skeletons: tuple[FrameRow, ...]


def read_frame_rows(sequence: StoredSequence) -> list[FrameRows]:
    """Read all frames in order. Raises FileError for a damaged table."""
    path = sequence.folder / TRUTH
    rows = _rows(path, TRUTH_SCHEMA)
    T, count = len(TARGETS), sequence.frame_count
    if len(rows) != T * count:
        raise FileError(path, f"must have {T * count} rows ({count} frames), has {len(rows)}")
    objects = _objects(sequence)
    skeletons = _skeletons(sequence, count)
    frames = []
    for index in range(count):
        targets = tuple(rows[T * index : T * (index + 1)])
        if [(row["frame_index"], row["target"]) for row in targets] != [
            (index, t) for t in TARGETS
        ]:
            raise FileError(
                path, f"frame {index}: must have the rows of {', '.join(TARGETS)}, in this order"
            )
        for t, row in enumerate(targets):
            if not _shaped(row, sum(target == t for target, _ in KEYPOINTS)):
                raise FileError(
                    path, f"frame {index}: {row['target']}: a box or keypoint is of the wrong size"
                )
        first = targets[0]
        frames.append(
            FrameRows(
                index,
                first["time_s"],
                first["stamp_s"],
                {camera: first[f"arrived_{camera}"] for camera in CAMERAS},
                targets,
                tuple(objects.get(index, ())),
                skeletons[index],
            )
        )
    return frames


def object_kinds(sequence: StoredSequence) -> dict[str, str]:
    """Kind of each object by its name, e.g. a can."""
    listed = sequence.rig_json.get("objects")
    try:
        return {str(item["name"]): str(item["kind"]) for item in listed or ()}
    except (KeyError, TypeError) as fault:
        raise FileError(sequence.folder / RIG, "objects: is not a list of name, kind") from fault


def box_of(row: FrameRow, camera: str, prefix: str = "") -> list[float] | None:
    """x, y, width, height of a target's row in a view, None where nothing of it is visible.

    prefix: "amodal_" for the box of the amodal mask.
    """
    values = [row[f"{prefix}box_{part}_{camera}_px"] for part in ("x", "y", "width", "height")]
    return None if None in values else values


def _objects(sequence: StoredSequence) -> dict[int, list[FrameRow]]:
    objects: dict[int, list[FrameRow]] = {}
    for row in _rows(sequence.folder / OBJECTS, OBJECTS_SCHEMA):
        objects.setdefault(row["frame_index"], []).append(row)
    return objects


def _skeletons(sequence: StoredSequence, frames: int) -> list[tuple[FrameRow, ...]]:
    """The rows of skeletons.parquet by frame."""
    path = sequence.folder / SKELETON
    rows = _rows(path, SKELETON_SCHEMA)
    wanted = [(index, name) for index in range(frames) for name in SKELETONS]
    if [(row["frame_index"], row["skeleton"]) for row in rows] != wanted:
        raise FileError(
            path, f"must have the rows of {', '.join(SKELETONS)}, in this order, of {frames} frames"
        )
    for row in rows:
        name = row["skeleton"]
        count = len(SKELETONS[name])
        angles = [len(finger or ()) for finger in row["finger_angles_rad"]]
        shaped = _points(row["points_m"], [OCCLUDED] * count, 3) and all(
            len(row[f"point_status_{camera}"]) == count
            and _points(row[f"points_{camera}_px"], row[f"point_status_{camera}"], 2)
            for camera in CAMERAS
        )
        if not shaped or angles != ([3] * 5 if name in HAND_SKELETONS else []):
            frame = row["frame_index"]
            raise FileError(path, f"frame {frame}: {name}: a point or angle is of the wrong size")
    n = len(SKELETONS)
    return [tuple(rows[n * index : n * (index + 1)]) for index in range(frames)]


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
    """Whether a target's row has a box if it is visible, and keypoints of the right sizes."""
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
    """Whether there is a point for each status, with all its numbers unless NOT_LABELLED."""
    return len(points) == len(status) and all(
        point is not None
        and len(point) == size
        and state in (NOT_LABELLED, OCCLUDED, VISIBLE)
        and (state == NOT_LABELLED or None not in point)
        for point, state in zip(points, status, strict=True)
    )
