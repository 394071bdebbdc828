"""Writes a sequence into a folder: renders in this thread, encodes and writes in others."""

from __future__ import annotations

import json
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pjpdaf.calibration import write_rig
from pjpdaf.camera import StereoRig
from pjpdaf.frames import StereoFrame
from sim.dataset.files import encode
from sim.dataset.files.cameras import camera_record
from sim.dataset.files.checksums import files_below, sha256_of, text_of
from sim.dataset.files.encoder import FileEncoder, encoding_into
from sim.dataset.files.layout import (
    CALIBRATION,
    CHECKSUMS,
    ERROR_FREE,
    EVENTS,
    OBJECTS,
    RECIPE,
    RIG,
    SKELETON,
    TRUTH,
    picture_name,
)
from sim.dataset.files.table_writer import TableWriter, writing_tables
from sim.dataset.files.tables import object_rows, skeleton_rows, truth_rows
from sim.dataset.labels.events import events_of
from sim.dataset.labels.instances import Instances
from sim.dataset.labels.labeller import Labeller
from sim.dataset.labels.records import FrameLabels, Matches, ViewLabels
from sim.scene.world import CAMERAS
from sim.sequence import RenderedFrame, Simulation
from sim.truth import Truth


@dataclass(frozen=True)
class Written:
    """Numbers of frames, files and bytes that were written."""

    frames: int
    files: int
    bytes: int


def write_sequence(
    simulation: Simulation,
    folder: Path,
    labels: Collection[str],
    recipe: Mapping[str, Any],
    on_frame: Callable[[int], None] = lambda frame: None,
) -> Written:
    """Write a whole sequence into an empty folder, its checksums last.

    labels: of `layout.LABELS`; recipe: from which the sequence can be made again, written as it is;
    on_frame is called after each frame. Raises OSError of the disk.
    """
    labeller = _labeller(simulation, labels)
    with encoding_into(folder) as files, writing_tables(folder) as tables:
        for frame in simulation.background():
            _add_pictures(files, "background_", frame)
        truths: list[Truth] = []
        hidden: list[list[NDArray[np.int64]]] = []
        for index in range(simulation.frame_count):
            rendered, frame_labels = _add_frame(labeller, files, tables, labels, index)
            if "flow" in labels and index:
                _add_flow(labeller, files, index - 1, ("forward", "backward"))
            truths.append(rendered.truth)
            hidden.append([view.hidden_px for view in frame_labels.views])
            on_frame(index)
        records = {
            EVENTS: events_of(truths, hidden, labeller.instances),
            RECIPE: recipe,
            RIG: rig_record(simulation, labeller.instances),
        }
        for name, record in records.items():
            files.add(name, partial(_json, record))
    write_rig(simulation.calibration, folder / CALIBRATION)
    write_rig(simulation.rig, folder / CALIBRATION / ERROR_FREE)
    paths = [path.relative_to(folder).as_posix() for path in files_below(folder)]
    sums = {path: files.sums.get(path) or sha256_of(folder / path) for path in paths}
    (folder / CHECKSUMS).write_text(text_of(sums), encoding="utf-8")
    size = sum((folder / path).stat().st_size for path in (*paths, CHECKSUMS))
    return Written(simulation.frame_count, len(paths) + 1, size)


def write_frames(
    simulation: Simulation, folder: Path, labels: Collection[str], indices: range
) -> None:
    """Write the pictures and labels of frames that follow each other, and the flow between these.

    Raises OSError of the disk.
    """
    labeller = _labeller(simulation, labels)
    with encoding_into(folder) as files, writing_tables(folder) as tables:
        for index in indices:
            _add_frame(labeller, files, tables, labels, index)
            if "flow" in labels and index > indices[0]:
                _add_flow(labeller, files, index - 1, ("forward", "backward"))


def write_frame(simulation: Simulation, folder: Path, labels: Collection[str], index: int) -> None:
    """Write the pictures and labels of one frame, under their names in the sequence.

    For optical flow the frames beside it are rendered as well.

    Raises OSError of the disk.
    """
    labeller = _labeller(simulation, labels)
    with encoding_into(folder) as files, writing_tables(folder) as tables:
        _add_frame(labeller, files, tables, labels, index)
        if "flow" in labels and index:
            _add_flow(labeller, files, index - 1, ("backward",))
        if "flow" in labels and index + 1 < simulation.frame_count:
            _add_flow(labeller, files, index, ("forward",))


def _labeller(simulation: Simulation, labels: Collection[str]) -> Labeller:
    return Labeller(simulation, [name for name in labels if name in Labeller.WANTED])


def _add_frame(
    labeller: Labeller, files: FileEncoder, tables: TableWriter, labels: Collection[str], index: int
) -> tuple[RenderedFrame, FrameLabels]:
    """Render, label and write a frame."""
    rendered, frame_labels = labeller.labelled(index)
    frame, truth = rendered.frame, rendered.truth
    _add_pictures(files, "", frame)
    for camera, view, view_labels in zip(CAMERAS, rendered.views, frame_labels.views, strict=True):
        assert view.colour is not None
        _add_labels(files, labels, camera, index, view.colour, view_labels)
    arrived = [picture is not None for picture in frame.pictures]
    rows = truth_rows(frame.time_s, arrived, truth, frame_labels, labeller.instances)
    tables.add(TRUTH, rows)
    tables.add(OBJECTS, object_rows(truth, frame_labels))
    tables.add(SKELETON, skeleton_rows(truth, frame_labels))
    return rendered, frame_labels


def _add_flow(
    labeller: Labeller, files: FileEncoder, index: int, directions: Collection[str]
) -> None:
    """Write the flow from a frame to the next, and from the next back to it."""
    flow = labeller.flow(index)
    pairs = {"forward": (index, flow.forward), "backward": (index + 1, flow.backward)}
    for direction in directions:
        frame, views = pairs[direction]
        for camera, matches in zip(CAMERAS, views, strict=True):
            path = f"flow_{direction}_{camera}/{picture_name(frame)}"
            files.add(path, partial(_flow_png, matches))


def _flow_png(matches: Matches) -> bytes:
    return encode.png(encode.matches_to_png(matches))


def _add_pictures(files: FileEncoder, prefix: str, frame: StereoFrame) -> None:
    for camera, picture in zip(CAMERAS, frame.pictures, strict=True):
        if picture is not None:
            path = f"{prefix}{camera}/{picture_name(frame.index)}"
            files.add(path, partial(encode.png, picture))


def _add_labels(
    files: FileEncoder,
    wanted: Collection[str],
    camera: str,
    index: int,
    clean: NDArray[np.uint8],
    labels: ViewLabels,
) -> None:
    """Write the wanted labels of a view. clean: its picture without the sensor's effects."""
    name = picture_name(index)

    def add(label: str, folder: str, picture: Callable[[], NDArray[Any]]) -> None:
        if label in wanted:
            files.add(f"{folder}_{camera}/{name}", lambda: encode.png(picture()))

    add("clean", "clean", lambda: clean)
    add("depth", "depth", lambda: encode.depth_to_png(labels.depth_m))
    add("seg", "seg", lambda: labels.instances)
    add("amodal", "amodal", lambda: encode.amodal_to_png(labels.amodal))
    classes, normals = labels.classes, labels.normals
    if classes is not None:
        add("semantic", "semantic", lambda: classes)
    if normals is not None:
        add("normals", "normals", lambda: normals[..., ::-1])
    rectified, matches = labels.rectified, labels.matches
    if rectified is not None:
        add("disparity", "disparity", lambda: _disparity(rectified))
        add("disparity", "occlusion", lambda: rectified.status)
    if matches is not None:
        add("correspondence", "correspondence", lambda: encode.matches_to_png(matches))
    if "float" in wanted:
        arrays = {"depth_m": labels.depth_m}
        if rectified is not None and rectified.disparity_px is not None:
            arrays["disparity_px"] = rectified.disparity_px
        if matches is not None and matches.places_px is not None:
            arrays["places_px"] = matches.places_px
        files.add(f"float_{camera}/{picture_name(index, '.npz')}", lambda: encode.npz(**arrays))


def _disparity(rectified: Matches) -> NDArray[np.uint16]:
    assert rectified.disparity_px is not None
    return encode.disparity_to_png(rectified.disparity_px)


def rig_record(simulation: Simulation, instances: Instances) -> dict[str, Any]:
    """The content of `rig.json`: cameras in the world to the last bit, frame rate, instances."""
    performance = simulation.performance
    return {
        "fps": performance.fps,
        "frames": performance.frames,
        "background_frames": performance.background_frames,
        "redrawn": performance.redrawn,
        "skew_s": performance.scene.sensor.skew_s,
        "cameras": _cameras(simulation.rig),
        "calibration": _cameras(simulation.calibration),
        "instances": [
            {"id": instance.id, "name": instance.name, "kind": instance.kind}
            for instance in instances.table
        ],
        "objects": [
            {"name": spec.name, "kind": spec.kind, "size_m": list(spec.size_m)}
            for spec in performance.scene.room.objects
        ],
    }


def _cameras(rig: StereoRig) -> dict[str, Any]:
    return {name: camera_record(camera) for name, camera in zip(CAMERAS, rig.cameras, strict=True)}


def _json(record: Mapping[str, Any]) -> bytes:
    return (json.dumps(record, indent=1, ensure_ascii=False) + "\n").encode()
