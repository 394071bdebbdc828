"""The numbers of a sequence on the page: values, boxes, keypoints and events by frame."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from pjpdaf.targets import TARGETS
from reports.dataset import label_colours
from reports.dataset.event_rows import event_rows
from reports.dataset.sequence_view import SequenceView
from reports.words import readable_name
from sim.dataset.export.coco_ids import categories
from sim.dataset.files.layout import EVENTS, SKELETON
from sim.dataset.files.reading import read_json
from sim.dataset.labels.records import SKELETONS
from sim.dataset.stored_sequence import StoredSequence
from sim.scene.world import CAMERAS


def sequence_data(view: SequenceView) -> dict[str, Any]:
    """A sequence's numbers as plain values: whole 0.1 mm, mm/s, 0.1 px, per mille, ms.

    Each list has an entry per frame, and in it an entry per view and target, keypoint or skeleton.
    """
    sequence, T = view.sequence, len(TARGETS)
    rows = sequence.truth.iloc[: T * view.frames].to_dict("records")
    frames = [rows[i : i + T] for i in range(0, len(rows), T)]
    rigs = sequence.rig.cameras
    skeletons = _skeleton_rows(sequence, view.frames)
    return {
        "name": view.name,
        "fps": sequence.fps,
        "sequence_frames": sequence.frame_count,
        "size": [[camera.width_px, camera.height_px] for camera in rigs],
        "ms": [_whole(mine[0]["time_s"], 1e3) for mine in frames],
        "arrived": [[int(bool(mine[0][f"arrived_{c}"])) for c in CAMERAS] for mine in frames],
        "positions": [[[_whole(r[f"{a}_m"], 1e4) for a in "xyz"] for r in mine] for mine in frames],
        "speeds": [[_speed(r) for r in mine] for mine in frames],
        "visible": _per_view(frames, _visible),
        "truncation": _per_view(frames, lambda r, c: _whole(r[f"truncation_{c}"], 1e3)),
        "boxes": _per_view(frames, lambda r, c: _box(r, f"box_{{}}_{c}_px")),
        "amodal_boxes": _per_view(frames, lambda r, c: _box(r, f"amodal_box_{{}}_{c}_px")),
        "occluders": _per_view(frames, _occluders),
        "merged_with": _per_view(
            frames, lambda r, c: [readable_name(str(o)[:40]) for o in r[f"merged_with_{c}"]]
        ),
        "keypoints": _per_view(frames, _keypoints),
        "skeletons": _per_view(skeletons, _skeleton),
        "bones": _bones(),
        "events": event_rows(read_json(sequence.folder / EVENTS), view.frames),
        "legend": [
            [_css_colour(label_colours.instance_colour(instance.id)), instance.name[:60]]
            for instance in sequence.instances
            if 0 <= instance.id <= 255
        ],
    }


def _skeleton_rows(sequence: StoredSequence, frames: int) -> list[list[Mapping[Any, Any]]]:
    """The rows of each frame's skeletons; none of a data set of version 1, which has no such."""
    if not (sequence.folder / SKELETON).exists():
        return [[] for _ in range(frames)]
    n = len(SKELETONS)
    rows = sequence.skeletons.iloc[: n * frames].to_dict("records")
    return [rows[i : i + n] for i in range(0, len(rows), n)]


def _bones() -> list[list[list[int]]]:
    """The pairs of points, from 0, that a line joins, of each skeleton."""
    pairs = {category["name"]: category.get("skeleton", []) for category in categories()}
    return [
        [[a - 1, b - 1] for a, b in pairs[name] if max(a, b) <= len(points)]
        for name, points in SKELETONS.items()
    ]


def _per_view(frames: Sequence[Sequence[Mapping[Any, Any]]], value: Any) -> list[Any]:
    """Apply a function of row and view's name: [frame][view][target]."""
    return [[[value(row, view) for row in mine] for view in CAMERAS] for mine in frames]


def _visible(row: Mapping[Any, Any], view: str) -> int | None:
    """Visible fraction [per mille], None out of the picture."""
    if not row[f"amodal_{view}_px"]:
        return None
    return _whole(row[f"visible_fraction_{view}"], 1e3)


def _box(row: Mapping[Any, Any], name: str) -> list[int] | None:
    values = [_whole(row[name.format(part)], 1) for part in ("x", "y", "width", "height")]
    return None if None in values else [v for v in values if v is not None]


def _occluders(row: Mapping[Any, Any], view: str) -> list[list[Any]]:
    """(name, share of the whole target [per mille]), the largest first, six at most."""
    whole = max(int(row[f"amodal_{view}_px"] or 0), 1)
    listed = [(str(o["instance"])[:60], int(o["pixels"])) for o in row[f"occluded_by_{view}"]]
    listed.sort(key=lambda occluder: (-occluder[1], occluder[0]))
    return [[readable_name(name), round(1000 * pixels / whole)] for name, pixels in listed[:6]]


def _keypoints(row: Mapping[Any, Any], view: str) -> list[list[int | None]]:
    """x, y [0.1 px] and status of a target's keypoints."""
    return _points(row[f"keypoints_{view}_px"], row[f"keypoint_status_{view}"])


def _skeleton(row: Mapping[Any, Any], view: str) -> list[list[int | None]]:
    """x, y [0.1 px] and status of a skeleton's points."""
    return _points(row[f"points_{view}_px"], row[f"point_status_{view}"])


def _points(pixels: Any, states: Any) -> list[list[int | None]]:
    return [
        [_whole(x, 10), _whole(y, 10), int(state)]
        for (x, y), state in zip(pixels, states, strict=True)
    ]


def _speed(row: Mapping[Any, Any]) -> int | None:
    return _whole(float(np.linalg.norm([row[f"v{a}_mps"] for a in "xyz"])), 1e3)


def _whole(value: Any, scale: float) -> int | None:
    if value is None or not np.isfinite(value):
        return None
    return round(float(value) * scale)


def _css_colour(colour: label_colours.Colour) -> str:
    b, g, r = colour
    return f"#{r:02x}{g:02x}{b:02x}"
