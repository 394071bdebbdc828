"""Writes one sequence into a folder: renders in this thread, encodes and writes in others."""

from __future__ import annotations

import hashlib
import json
from collections import deque
from collections.abc import Callable, Collection, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from pjpdaf.calibration import write_rig
from pjpdaf.camera import StereoRig
from pjpdaf.frames import StereoFrame
from pjpdaf.targets import TARGETS
from sim.dataset.files import encode
from sim.dataset.files.cameras import camera_record
from sim.dataset.files.checksums import sha256_of, text_of
from sim.dataset.files.layout import (
    CALIBRATION,
    CHECKSUMS,
    ERROR_FREE,
    EVENTS,
    OBJECTS,
    RECIPE,
    RIG,
    TRUTH,
    picture_name,
)
from sim.dataset.files.tables import OBJECTS_SCHEMA, TRUTH_SCHEMA, object_rows, truth_rows
from sim.dataset.labels.events import events_of
from sim.dataset.labels.instances import Instances
from sim.dataset.labels.labeller import Labeller
from sim.dataset.labels.records import KEYPOINTS, FrameLabels, Matches, ViewLabels
from sim.scene.world import CAMERAS
from sim.sequence import RenderedFrame, Simulation
from sim.truth import Truth

THREADS = 2  # encode beside the renderer
WAITING = 24  # files that wait to be encoded; bounds the memory
ROW_GROUP = 4096  # rows of a table that are held before Parquet takes them
_MINE = [[k for k, (target, _) in enumerate(KEYPOINTS) if target == t] for t in range(len(TARGETS))]


@dataclass(frozen=True)
class Written:
    """What was written: frames, files and bytes."""

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
    """Write all of a sequence into an empty folder, its checksums last.

    labels: of `layout.LABELS`; recipe: from which it can be made again, written as it is; on_frame
    is called after each frame. Raises OSError of the disk.
    """
    labeller = Labeller(simulation, [name for name in labels if name in Labeller.WANTED])
    with _Files(folder) as files, _Tables(folder) as tables:
        for frame in simulation.background():
            _add_pictures(files, "background_", frame)
        truths: list[Truth] = []
        hidden: list[list[NDArray[np.int64]]] = []
        for index in range(simulation.performance.frames):
            rendered, said = labeller.labelled(index)
            _add_pictures(files, "", rendered.frame)
            for view, camera in enumerate(CAMERAS):
                _add_labels(files, labels, camera, index, rendered, said.views[view])
            tables.add(rendered, said, labeller.instances)
            truths.append(rendered.truth)
            hidden.append([one.hidden_px for one in said.views])
            on_frame(index)
        files.add(EVENTS, _json(events_of(truths, hidden, labeller.instances)))
        files.add(RECIPE, _json(recipe))
        files.add(RIG, _json(rig_record(simulation, labeller.instances)))
    _write_calibration(folder / CALIBRATION, simulation.calibration, simulation.rig)
    paths = [p.relative_to(folder).as_posix() for p in folder.rglob("*") if p.is_file()]
    sums = {path: files.sums.get(path) or sha256_of(folder / path) for path in paths}
    (folder / CHECKSUMS).write_text(text_of(sums), encoding="utf-8")
    size = sum((folder / path).stat().st_size for path in (*paths, CHECKSUMS))
    return Written(simulation.performance.frames, len(paths) + 1, size)


def write_frame(simulation: Simulation, folder: Path, labels: Collection[str], index: int) -> None:
    """Write the pictures and labels of one frame of a sequence, under the names they have in it.

    Raises OSError of the disk.
    """
    labeller = Labeller(simulation, [name for name in labels if name in Labeller.WANTED])
    with _Files(folder) as files, _Tables(folder) as tables:
        rendered, said = labeller.labelled(index)
        _add_pictures(files, "", rendered.frame)
        for view, camera in enumerate(CAMERAS):
            _add_labels(files, labels, camera, index, rendered, said.views[view])
        tables.add(rendered, said, labeller.instances)


def _add_pictures(files: _Files, prefix: str, frame: StereoFrame) -> None:
    for camera, picture in zip(CAMERAS, frame.pictures, strict=True):
        if picture is not None:
            files.encode(f"{prefix}{camera}/{picture_name(frame.index)}", encode.png, picture)


def _add_labels(
    files: _Files,
    labels: Collection[str],
    camera: str,
    index: int,
    rendered: RenderedFrame,
    said: ViewLabels,
) -> None:
    name = picture_name(index)

    def add(label: str, folder: str, make: Callable[[], NDArray[Any]]) -> None:
        if label in labels:
            files.encode(f"{folder}_{camera}/{name}", lambda _: encode.png(make()), None)

    clean = rendered.views[CAMERAS.index(camera)].colour
    assert clean is not None
    add("clean", "clean", lambda: clean)
    add("depth", "depth", lambda: encode.depth_to_png(said.depth_m))
    add("seg", "seg", lambda: said.instances)
    add("amodal", "amodal", lambda: encode.amodal_to_png(said.amodal))
    rectified, matches = said.rectified, said.matches
    if rectified is not None:
        add("disparity", "disparity", lambda: _disparity(rectified))
        add("disparity", "occlusion", lambda: rectified.status)
    if matches is not None:
        add("correspondence", "correspondence", lambda: encode.matches_to_png(matches))
    if "float" in labels:
        arrays = {"depth_m": said.depth_m}
        if rectified is not None and rectified.disparity_px is not None:
            arrays["disparity_px"] = rectified.disparity_px
        if matches is not None and matches.places_px is not None:
            arrays["places_px"] = matches.places_px
        where = f"float_{camera}/{picture_name(index, '.npz')}"
        files.encode(where, lambda held: encode.npz(**held), arrays)


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
            {"id": one.id, "name": one.name, "kind": one.kind} for one in instances.table
        ],
        "objects": [
            {"name": thing.name, "kind": thing.kind, "size_m": list(thing.size_m)}
            for thing in performance.scene.room.objects
        ],
    }


def _cameras(rig: StereoRig) -> dict[str, Any]:
    return {name: camera_record(c) for name, c in zip(CAMERAS, rig.cameras, strict=True)}


def _write_calibration(folder: Path, given: StereoRig, rig: StereoRig) -> None:
    write_rig(given, folder)
    write_rig(rig, folder / ERROR_FREE)


def _json(record: Mapping[str, Any]) -> bytes:
    return (json.dumps(record, indent=1, ensure_ascii=False) + "\n").encode()


class _Files:
    """Encodes and writes in threads; the first fault comes out where the next file goes in."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._pool = ThreadPoolExecutor(THREADS)
        self._waiting: deque[Future[tuple[str, str]]] = deque()
        self._folders: set[Path] = set()
        self.sums: dict[str, str] = {}

    def encode(self, path: str, encoder: Callable[[Any], bytes], what: Any) -> None:
        """Write `encoder(what)` to a path below the folder."""
        while len(self._waiting) >= WAITING:
            self._take()
        where = self._folder / path
        if where.parent not in self._folders:
            where.parent.mkdir(parents=True, exist_ok=True)
            self._folders.add(where.parent)
        self._waiting.append(self._pool.submit(_write, where, path, encoder, what))

    def add(self, path: str, data: bytes) -> None:
        """Write bytes."""
        self.encode(path, bytes, data)

    def _take(self) -> None:
        path, digest = self._waiting.popleft().result()
        self.sums[path] = digest

    def __enter__(self) -> _Files:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        try:
            while self._waiting and kind is None:
                self._take()
        finally:
            self._pool.shutdown(cancel_futures=True)


def _write(where: Path, path: str, encoder: Callable[[Any], bytes], what: Any) -> tuple[str, str]:
    data = encoder(what)
    where.write_bytes(data)
    return path, hashlib.sha256(data).hexdigest()


class _Tables:
    """Both tables, written a group of rows at a time: memory does not grow with their length."""

    def __init__(self, folder: Path) -> None:
        self._paths = {TRUTH: TRUTH_SCHEMA, OBJECTS: OBJECTS_SCHEMA}
        self._writers = {
            name: pq.ParquetWriter(folder / name, schema, compression="zstd")
            for name, schema in self._paths.items()
        }
        self._held: dict[str, list[dict[str, Any]]] = {name: [] for name in self._paths}

    def add(self, rendered: RenderedFrame, labels: FrameLabels, instances: Instances) -> None:
        arrived = [picture is not None for picture in rendered.frame.pictures]
        self._held[TRUTH] += truth_rows(
            rendered.frame.time_s, arrived, rendered.truth, labels, instances, _MINE
        )
        self._held[OBJECTS] += object_rows(rendered.truth, labels)
        for name, rows in self._held.items():
            if len(rows) >= ROW_GROUP:
                self._hand_over(name)

    def _hand_over(self, name: str) -> None:
        if not self._held[name]:
            return  # a row group without rows is more than some readers bear
        table = pa.Table.from_pylist(self._held[name], schema=self._paths[name])
        self._writers[name].write_table(table)
        self._held[name] = []

    def __enter__(self) -> _Tables:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        for name, writer in self._writers.items():
            if kind is None:
                self._hand_over(name)
            writer.close()
