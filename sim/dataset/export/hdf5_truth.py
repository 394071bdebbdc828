"""The truth of a sequence as arrays over its frames, for HDF5."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from pjpdaf.errors import FileError
from pjpdaf.targets import TARGETS
from sim.dataset.export.frame_columns import BOOLEAN, COLUMNS, FLOAT, INTEGER
from sim.dataset.files.layout import OBJECTS, TRUTH
from sim.dataset.frame_rows import FrameRows
from sim.dataset.labels.instances import NOTHING
from sim.dataset.stored_sequence import StoredSequence
from sim.scene.world import CAMERAS

_TYPES = {FLOAT: np.float64, INTEGER: np.int64, BOOLEAN: np.uint8}


def truth_arrays(sequence: StoredSequence, frames: Sequence[FrameRows]) -> dict[str, Any]:
    """The columns of `frame_columns` with frames as the first axis, and lists of names by name.

    events_of_frames (F, E) and occluded_..._px (F, T, I) have an element for each of the names
    `events` and `instances`. Arrays of objects are there where there are objects. Raises FileError
    for damaged tables.
    """
    events = sorted({event for frame in frames for event in frame.targets[0]["events"]})
    shown = [[event in frame.targets[0]["events"] for event in events] for frame in frames]
    objects = [row["object"] for row in frames[0].objects]
    if any([row["object"] for row in frame.objects] != objects for frame in frames):
        raise FileError(sequence.folder / OBJECTS, "must have the same objects in all frames")
    ids = {"nothing": NOTHING, **{one.name: one.id for one in sequence.instances}}
    names = {"targets": list(TARGETS), "events": events, "objects": objects, "instances": list(ids)}
    arrays: dict[str, Any] = {
        **{name: texts for name, texts in names.items() if texts},
        "instance_ids": np.array(list(ids.values()), np.uint8),
        "events_of_frames": np.array(shown, np.uint8).reshape(len(frames), len(events)),
        "arrived": np.array([[f.arrived[c] for c in CAMERAS] for f in frames], np.uint8),
    }
    for camera in CAMERAS:
        arrays[f"occluded_{camera}_px"] = _occluded(sequence, frames, camera, list(ids))
    for name, kind, value in COLUMNS:
        scalar = _scalar(kind)
        of_objects = name.startswith("object_")
        if name not in arrays and scalar in _TYPES and (objects or not of_objects):
            arrays[name] = np.array([value(frame) for frame in frames], _TYPES[scalar])
    return arrays


def _occluded(
    sequence: StoredSequence, frames: Sequence[FrameRows], camera: str, names: list[str]
) -> NDArray[np.int64]:
    """Pixels of each target that each instance hides in a view (F, T, I)."""
    pixels = np.zeros((len(frames), len(TARGETS), len(names)), np.int64)
    for frame, of_targets in zip(frames, pixels, strict=True):
        for row, of_instances in zip(frame.targets, of_targets, strict=True):
            for by in row[f"occluded_by_{camera}"]:
                if by["instance"] not in names:
                    unknown = f"frame {frame.index}: no instance {str(by['instance'])[:40]!r}"
                    raise FileError(sequence.folder / TRUTH, unknown)
                of_instances[names.index(by["instance"])] += by["pixels"]
    return pixels


def _scalar(kind: pa.DataType) -> pa.DataType:
    """The type of the values in lists of any depth."""
    while pa.types.is_list(kind):
        kind = kind.value_type
    return kind
