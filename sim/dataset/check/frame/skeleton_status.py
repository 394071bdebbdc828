"""The status of the points of skeletons.parquet against the ids at their pixels."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from pjpdaf.targets import HEAD, TARGETS
from sim.dataset.check.fault import FrameFault
from sim.dataset.check.frame.arrays import FrameArrays, present
from sim.dataset.check.frame_tables import FrameTables
from sim.dataset.files.layout import SKELETON
from sim.dataset.labels.instances import PERSON
from sim.dataset.labels.records import (
    BODY_SKELETON,
    HAND_SKELETONS,
    NOT_LABELLED,
    SKELETONS,
    VISIBLE,
)
from sim.scene.world import CAMERAS

_FACE = ("nose", "left_eye", "right_eye", "left_ear", "right_ear")


def _ids(skeleton: str, point: str) -> set[int]:
    """Ids that a visible point may show: of its hand, of the face, of the clothed body."""
    if skeleton in HAND_SKELETONS:
        return {1 + TARGETS.index(skeleton)}
    assert skeleton == BODY_SKELETON
    if point in _FACE:
        return {1 + HEAD}
    side, _, part = point.partition("_")
    return {PERSON, 1 + TARGETS.index(f"{side}_hand")} if part == "wrist" else {PERSON}


_POINTS = [(name, point) for name, points in SKELETONS.items() for point in points]
_SHOWN = [_ids(*point) for point in _POINTS]


def skeleton_faults(frame: FrameArrays, view: int, tables: FrameTables) -> Iterator[FrameFault]:
    """Check that the points inside the picture have a status, and the visible an id of theirs."""
    seg = present(frame.views[view].seg)
    pixels, status = tables.skeleton_px[view], tables.skeleton_status[view]
    at = np.floor(pixels + 0.5)
    inside = np.asarray((at >= 0).all(axis=1) & (at < np.array(seg.shape[::-1])).all(axis=1))
    file, kind = f"{frame.sequence}/{SKELETON}", f"point_status, {CAMERAS[view]} view"
    for k in np.flatnonzero(inside != (status != NOT_LABELLED)).tolist():
        text = f"{':'.join(_POINTS[k])} has {status[k]}, inside: {inside[k]}"
        yield FrameFault(file, kind, frame.index, text)
    for k in np.flatnonzero(inside & (status == VISIBLE)).tolist():
        x, y = at[k].astype(int)
        if int(seg[y, x]) not in _SHOWN[k]:
            text = f"{':'.join(_POINTS[k])} is visible, its pixel has the id {seg[y, x]}"
            yield FrameFault(file, kind, frame.index, text)
