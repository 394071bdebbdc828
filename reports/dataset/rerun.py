"""A data set as a recording for the Rerun viewer: cameras, pictures, labels, positions, events."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from pjpdaf.targets import TARGETS
from reports.dataset import label_colours
from reports.dataset.event_rows import event_rows
from reports.pictures.encode import jpeg_of
from reports.rerun.recording import (
    CORNER_PX,
    QUALITY,
    TARGET_RGB,
    Entities,
    identity_of,
    write_recording,
)
from reports.words import LABELS as WORDS
from sim.dataset.files.layout import DEPTH_UNIT_M, picture_name
from sim.dataset.labels.records import OCCLUDED, VISIBLE
from sim.dataset.reader import Dataset
from sim.dataset.stored_sequence import StoredSequence
from sim.scene.world import CAMERAS

OCCLUDED_RGB = (150, 150, 150)


def write_dataset_rerun(dataset: Dataset, sequences: Sequence[StoredSequence], file: Path) -> Path:
    """Write these sequences into one new `file` (.rrd) and return it.

    Entities are seq_NNNNNN/..., on the timelines `frame` and `time`; lengths in metres, the
    simulator's world, pixels of the pictures as filmed. The viewer knows no lens: in a sequence
    with lens distortion 3-D points miss the pictures, and its depth is left out.

    Raises as `write_recording`.
    """

    def log_all(rr: Any, blueprint: Any, stream: Any) -> Any:
        for sequence in sequences:
            _log_sequence(Entities(rr, stream, (sequence.name,)), sequence)
        return blueprint.Tabs(*[_layout(blueprint, sequence) for sequence in sequences])

    identity = identity_of([dict(sequence.entry) for sequence in sequences])
    return write_recording(file, dataset.folder.name, identity, log_all)


def _log_sequence(entities: Entities, sequence: StoredSequence) -> None:
    rr = entities.rr
    entities.log_static((), rr.ViewCoordinates.RIGHT_HAND_Z_UP)
    names = rr.AnnotationContext(
        [
            rr.AnnotationInfo(entry.id, entry.name, label_colours.instance_colour(entry.id)[::-1])
            for entry in sequence.instances
        ]
    )
    for view, camera in zip(CAMERAS, sequence.rig.cameras, strict=True):
        entities.log_camera(view, camera, names)
    rows = sequence.truth.to_dict("records")
    T = len(TARGETS)
    events: dict[int, list[str]] = {}
    for event in event_rows(sequence.events, sequence.frame_count):
        for first, last in event["spans"]:
            events.setdefault(first, []).append(f"{event['text']}, to frame {last}")
    for index in range(sequence.frame_count):
        mine = rows[T * index : T * (index + 1)]
        entities.stream.set_time("frame", sequence=index)
        entities.stream.set_time("time", duration=float(mine[0]["time_s"]))
        _log_positions(entities, mine)
        for v, view in enumerate(CAMERAS):
            _log_pictures(entities, sequence, v, view, index, bool(mine[0][f"arrived_{view}"]))
            _log_marks(entities, view, mine)
        for text in events.get(index, ()):
            entities.log(("events",), rr.TextLog(text, level="INFO"))


def _log_pictures(
    entities: Entities, sequence: StoredSequence, v: int, view: str, index: int, arrived: bool
) -> None:
    rr, below = entities.rr, ("cameras", view)
    if arrived:
        picture = sequence.picture(view, index, np.uint8, 3)
        jpeg = jpeg_of(picture, QUALITY, optimised=True)
        entities.log((*below, "picture"), rr.EncodedImage(contents=jpeg, media_type="image/jpeg"))
    else:
        entities.log((*below, "picture"), rr.Clear(recursive=False))
    if sequence.has(f"seg_{view}"):
        entities.log((*below, "seg"), rr.SegmentationImage(sequence.seg(v, index), opacity=0.35))
    if sequence.has(f"depth_{view}") and not sequence.rig.cameras[v].distortion.any():
        sequence.depth_m(v, index)  # checks it
        png = (sequence.folder / f"depth_{view}" / picture_name(index)).read_bytes()
        entities.log(
            (*below, "depth"),
            rr.EncodedDepthImage(blob=png, media_type="image/png", meter=1 / DEPTH_UNIT_M),
        )


def _log_marks(entities: Entities, view: str, rows: Sequence[Any]) -> None:
    """Boxes of the visible skin and keypoints, in the viewer's pixels (from the corner)."""
    rr, below = entities.rr, ("cameras", view)
    for t, (target, row) in enumerate(zip(TARGETS, rows, strict=True)):
        box = [row[f"box_{part}_{view}_px"] for part in ("x", "y", "width", "height")]
        there = bool(np.isfinite(np.array(box, np.float64)).all())
        entities.log(
            (*below, "boxes", target),
            rr.Boxes2D(
                array=[box] if there else [],
                array_format=rr.Box2DFormat.XYWH,
                colors=[TARGET_RGB[t]],
                labels=[WORDS[target]] if there else [],
            ),
        )
        states = np.array(row[f"keypoint_status_{view}"])
        shown = np.isin(states, (OCCLUDED, VISIBLE))
        points = [p for p, s in zip(row[f"keypoints_{view}_px"], shown, strict=True) if s]
        entities.log(
            (*below, "keypoints", target),
            rr.Points2D(
                np.array([list(p) for p in points], np.float64).reshape(-1, 2) + CORNER_PX,
                colors=[TARGET_RGB[t] if s == VISIBLE else OCCLUDED_RGB for s in states[shown]],
                radii=[2.5],
            ),
        )


def _log_positions(entities: Entities, rows: Sequence[Any]) -> None:
    rr = entities.rr
    for t, (target, row) in enumerate(zip(TARGETS, rows, strict=True)):
        centre = [row[f"{a}_m"] for a in "xyz"]
        entities.log(
            ("truth", target), rr.Points3D([centre], colors=[TARGET_RGB[t]], radii=[0.012])
        )
        points = np.array([list(p) for p in row["keypoints_m"]], np.float64).reshape(-1, 3)
        entities.log(
            ("keypoints", target), rr.Points3D(points, colors=[TARGET_RGB[t]], radii=[0.005])
        )
        for view in CAMERAS:
            share = float(row[f"visible_fraction_{view}"])
            entities.log(("visible_fraction", view, target), rr.Scalars(share))


def _layout(blueprint: Any, sequence: StoredSequence) -> Any:
    """The views of one sequence."""
    root = f"/{sequence.name}"
    pictures = [
        blueprint.Spatial2DView(
            origin=f"{root}/cameras/{view}",
            contents=["$origin/picture", "$origin/seg", "$origin/boxes/**", "$origin/keypoints/**"],
            name=view,
        )
        for view in CAMERAS
    ]
    return blueprint.Horizontal(
        blueprint.Vertical(
            blueprint.Horizontal(*pictures),
            blueprint.Spatial3DView(origin=root, name="3-D"),
        ),
        blueprint.Vertical(
            blueprint.TimeSeriesView(origin=f"{root}/visible_fraction", name="visible fraction"),
            blueprint.TextLogView(origin=f"{root}/events", name="events"),
        ),
        column_shares=[3, 2],
        name=str(sequence.entry.get("label", sequence.name)),
    )
