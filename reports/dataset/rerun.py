"""A data set as a recording for the Rerun viewer: cameras, pictures, labels, positions, events."""

from __future__ import annotations

import hashlib
import importlib
import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from pjpdaf.errors import BenchError, InfrastructureError
from pjpdaf.targets import TARGETS
from reports.dataset import colours as look
from reports.dataset.page import event_rows
from reports.page.rerun import APPLICATION, CORNER_PX, ESTIMATE_RGB, QUALITY, SUFFIX
from reports.pictures.contact_sheet import jpeg_of
from reports.summary.tables import LABELS as WORDS
from sim.dataset.files.layout import DEPTH_UNIT_M, picture_name
from sim.dataset.labels.records import OCCLUDED, VISIBLE
from sim.dataset.reader import Dataset
from sim.dataset.stored_sequence import StoredSequence
from sim.files import disk_faults, written_whole_file
from sim.scene.world import CAMERAS

OCCLUDED_RGB = (150, 150, 150)


def write_dataset_rerun(dataset: Dataset, sequences: Sequence[StoredSequence], file: Path) -> Path:
    """Write these sequences into one new `file` (.rrd) and return it.

    Entities are seq_NNNNNN/..., on the timelines `frame` and `time`; lengths in metres, the
    simulator's world, pixels of the pictures as filmed. The viewer knows no lens: what lies in 3-D
    does not meet the pictures of a sequence with one, and its depth is left out.

    Raises BenchError where the file exists or ends otherwise, InfrastructureError where Rerun is
    not installed or switched off, or the disk is full.
    """
    if file.suffix.lower() != SUFFIX:
        raise BenchError(f"{file}: must end in {SUFFIX}.")
    try:
        rr = importlib.import_module("rerun")
    except ImportError:
        raise InfrastructureError(
            f"{file}: recordings need the extra: pip install 'pjpdaf-bench[viz]'."
        ) from None
    with written_whole_file(file, "the recording") as part:
        before = rr.strict_mode()
        rr.set_strict_mode(True)  # else Rerun warns of a fault and leaves the data out
        try:
            content = _recording(rr, dataset, sequences)
        finally:
            rr.set_strict_mode(before)
        with disk_faults(file, "the recording"):
            part.write_bytes(content)
    return file


def _recording(rr: Any, dataset: Dataset, sequences: Sequence[StoredSequence]) -> bytes:
    named = json.dumps([dict(one.entry) for one in sequences], sort_keys=True)
    identity = hashlib.sha256(named.encode()).hexdigest()[:32]
    # Its own properties are the wall-clock time and the program's name.
    stream = rr.RecordingStream(APPLICATION, recording_id=identity, send_properties=False)
    if hasattr(stream, "set_log_time_enabled"):  # of newer ones; the wall clock is no label
        stream.set_log_time_enabled(False)
    if not rr.is_enabled(stream):
        raise InfrastructureError("Rerun is switched off by the variable RERUN: unset it.")
    buffer = stream.binary_stream()
    stream.send_recording_name(dataset.folder.name)
    for sequence in sequences:
        _log_sequence(_Log(rr, stream, sequence))
    blueprint = importlib.import_module("rerun.blueprint")
    stream.send_blueprint(blueprint.Tabs(*[_layout(blueprint, one) for one in sequences]))
    content: bytes = buffer.read()  # once: a second part would follow the file's end mark
    stream.disconnect()
    return content


@dataclass(frozen=True, eq=False)
class _Log:
    """Where a sequence's data go."""

    rr: Any
    stream: Any
    sequence: StoredSequence

    def always(self, parts: Sequence[str], *what: Any) -> None:
        """Of no time."""
        self.stream.log(self._path(parts), *what, static=True)

    def now(self, parts: Sequence[str], *what: Any) -> None:
        """At the frame set last."""
        self.stream.log(self._path(parts), *what)

    def at(self, index: int, time_s: float) -> None:
        """Set the frame."""
        self.stream.set_time("frame", sequence=index)
        self.stream.set_time("time", duration=time_s)

    def _path(self, parts: Sequence[str]) -> str:
        return str(self.rr.new_entity_path([self.sequence.name, *parts]))


def _log_sequence(log: _Log) -> None:
    rr, sequence = log.rr, log.sequence
    log.always((), rr.ViewCoordinates.RIGHT_HAND_Z_UP)
    for v, view in enumerate(CAMERAS):
        _log_camera(log, v, view)
    rows = sequence.truth.to_dict("records")
    T = len(TARGETS)
    told: dict[int, list[str]] = {}
    for event in event_rows(sequence.events, sequence.frame_count):
        for first, last in event["spans"]:
            told.setdefault(first, []).append(f"{event['words']}, to frame {last}")
    for index in range(sequence.frame_count):
        mine = rows[T * index : T * (index + 1)]
        log.at(index, float(mine[0]["time_s"]))
        _log_places(log, mine)
        for v, view in enumerate(CAMERAS):
            _log_pictures(log, v, view, index, bool(mine[0][f"arrived_{view}"]))
            _log_marks(log, view, mine)
        for words in told.get(index, ()):
            log.now(("events",), rr.TextLog(words, level="INFO"))


def _log_camera(log: _Log, v: int, view: str) -> None:
    rr, camera = log.rr, log.sequence.rig.cameras[v]
    K = np.array(camera.K)
    K[:2, 2] += CORNER_PX
    log.always(
        ("cameras", view),
        rr.Transform3D(translation=camera.centre_w, mat3x3=camera.R_cw.T),
        rr.Pinhole(
            image_from_camera=K,
            resolution=[camera.width_px, camera.height_px],
            camera_xyz=rr.ViewCoordinates.RDF,
            image_plane_distance=0.3,
        ),
        rr.AnnotationContext(
            [
                rr.AnnotationInfo(one.id, one.name, look.instance_colour(one.id)[::-1])
                for one in log.sequence.instances
            ]
        ),
    )


def _log_pictures(log: _Log, v: int, view: str, index: int, arrived: bool) -> None:
    rr, sequence, below = log.rr, log.sequence, ("cameras", view)
    if arrived:
        picture = sequence.picture(view, index, np.uint8, 3)
        jpeg = jpeg_of(picture, QUALITY)
        log.now((*below, "picture"), rr.EncodedImage(contents=jpeg, media_type="image/jpeg"))
    else:
        log.now((*below, "picture"), rr.Clear(recursive=False))
    if sequence.has(f"seg_{view}"):
        log.now((*below, "seg"), rr.SegmentationImage(sequence.seg(v, index), opacity=0.35))
    if sequence.has(f"depth_{view}") and not sequence.rig.cameras[v].distortion.any():
        sequence.depth_m(v, index)  # checks it
        png = (sequence.folder / f"depth_{view}" / picture_name(index)).read_bytes()
        log.now(
            (*below, "depth"),
            rr.EncodedDepthImage(blob=png, media_type="image/png", meter=1 / DEPTH_UNIT_M),
        )


def _log_marks(log: _Log, view: str, rows: Sequence[Any]) -> None:
    """Boxes of the visible skin and keypoints, in the viewer's pixels (from the corner)."""
    rr, below = log.rr, ("cameras", view)
    for t, (target, row) in enumerate(zip(TARGETS, rows, strict=True)):
        box = [row[f"box_{part}_{view}_px"] for part in ("x", "y", "width", "height")]
        there = bool(np.isfinite(np.array(box, np.float64)).all())
        log.now(
            (*below, "boxes", target),
            rr.Boxes2D(
                array=[box] if there else [],
                array_format=rr.Box2DFormat.XYWH,
                colors=[ESTIMATE_RGB[t]],
                labels=[WORDS[target]] if there else [],
            ),
        )
        states = np.array(row[f"keypoint_status_{view}"])
        shown = np.isin(states, (OCCLUDED, VISIBLE))
        points = [p for p, s in zip(row[f"keypoints_{view}_px"], shown, strict=True) if s]
        log.now(
            (*below, "keypoints", target),
            rr.Points2D(
                np.array([list(p) for p in points], np.float64).reshape(-1, 2) + CORNER_PX,
                colors=[ESTIMATE_RGB[t] if s == VISIBLE else OCCLUDED_RGB for s in states[shown]],
                radii=[2.5],
            ),
        )


def _log_places(log: _Log, rows: Sequence[Any]) -> None:
    rr = log.rr
    for t, (target, row) in enumerate(zip(TARGETS, rows, strict=True)):
        centre = [row[f"{a}_m"] for a in "xyz"]
        log.now(("truth", target), rr.Points3D([centre], colors=[ESTIMATE_RGB[t]], radii=[0.012]))
        points = np.array([list(p) for p in row["keypoints_m"]], np.float64).reshape(-1, 3)
        log.now(("keypoints", target), rr.Points3D(points, colors=[ESTIMATE_RGB[t]], radii=[0.005]))
        for view in CAMERAS:
            share = float(row[f"visible_fraction_{view}"])
            log.now(("visible_fraction", view, target), rr.Scalars(share))


def _layout(blueprint: Any, sequence: StoredSequence) -> Any:
    """Views of one sequence."""
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
