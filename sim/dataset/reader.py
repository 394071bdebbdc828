"""Reads a data set: the same records as a live simulation gives, and the labels beside them.

Everything in it is data from a stranger: nothing is executed or unpickled, and no path leads out.
"""

from __future__ import annotations

import json
import math
import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from pjpdaf.camera import Camera, StereoRig
from pjpdaf.errors import BenchError
from pjpdaf.frames import StereoFrame
from pjpdaf.targets import TARGETS
from sim.dataset import encode
from sim.dataset.instances import Instance
from sim.dataset.layout import (
    EVENTS,
    KIND,
    MANIFEST,
    OBJECTS,
    RECIPE,
    RIG,
    SCHEMA_VERSION,
    TRUTH,
    is_sequence_name,
    picture_name,
)
from sim.dataset.records import Matches
from sim.dataset.tables import OBJECTS_SCHEMA, TRUTH_SCHEMA, truth_of_rows
from sim.scene.world import CAMERAS
from sim.truth import Truth

MAX_JSON_BYTES = 256 << 20
MAX_PICTURE_BYTES = 1 << 30
MAX_ROWS = 10_000_000
MAX_TABLE_BYTES = 8 << 30  # unpacked
ORTHONORMAL = 1e-6  # how far R Rᵀ of a camera may be from the identity
# Columns of truth.parquet that a Truth does not need, and that take long to read.
_LABELS_ONLY = ("keypoint", "amodal_box_", "occluded_by_", "truncation_")


@dataclass(frozen=True, eq=False)
class Sequence:
    """One sequence. Its methods raise BenchError with the file's name where one is damaged.

    name: of its folder; entry: what the manifest says of it.
    """

    folder: Path
    entry: Mapping[str, Any]

    @property
    def name(self) -> str:
        """Its folder's name."""
        return self.folder.name

    @cached_property
    def rig_json(self) -> dict[str, Any]:
        """rig.json."""
        return read_json(self.path(RIG))

    @property
    def fps(self) -> float:
        """Frames a second."""
        return _number(self.folder / RIG, self.rig_json, "fps", least=0.001, most=10_000.0)

    @property
    def frame_count(self) -> int:
        """Frames."""
        return int(_number(self.folder / RIG, self.rig_json, "frames", least=1, most=1e6))

    @property
    def background_count(self) -> int:
        """Person-free frames."""
        return int(_number(self.folder / RIG, self.rig_json, "background_frames", 0, 1e5))

    @property
    def redrawn(self) -> int:
        """How many draws of its seed were thrown away (`sim.script.Performance`)."""
        return int(_number(self.folder / RIG, self.rig_json, "redrawn", 0, 1e5))

    @property
    def skew_s(self) -> float:
        """How much later than the left view the right one is exposed [s]."""
        return _number(self.folder / RIG, self.rig_json, "skew_s", least=0.0, most=10.0)

    @cached_property
    def rig(self) -> StereoRig:
        """The cameras that filmed, in the world."""
        return self._cameras("cameras")

    @cached_property
    def calibration(self) -> StereoRig:
        """The calibration that a tracker is given, with its errors where it has some."""
        return self._cameras("calibration")

    @cached_property
    def instances(self) -> tuple[Instance, ...]:
        """What the pixels of `seg` mean."""
        path, listed = self.folder / RIG, self.rig_json.get("instances")
        try:
            return tuple(
                Instance(int(one["id"]), str(one["name"]), str(one["kind"])) for one in listed or ()
            )
        except (KeyError, TypeError, ValueError, OverflowError) as fault:
            raise BenchError(f"{path}: instances: is not a list of id, name, kind.") from fault

    @cached_property
    def recipe(self) -> dict[str, Any]:
        """recipe.json."""
        return read_json(self.path(RECIPE))

    @cached_property
    def events(self) -> dict[str, Any]:
        """events.json."""
        return read_json(self.path(EVENTS))

    @cached_property
    def truth(self) -> pd.DataFrame:
        """truth.parquet: a row a frame and target."""
        return read_table(self.path(TRUTH), TRUTH_SCHEMA).to_pandas()

    @cached_property
    def objects(self) -> pd.DataFrame:
        """objects.parquet: a row a frame and object."""
        return read_table(self.path(OBJECTS), OBJECTS_SCHEMA).to_pandas()

    @property
    def truths(self) -> tuple[Truth, ...]:
        """The truth of every frame, in order, bit for bit as it was simulated."""
        return tuple(truth for truth, _, _ in self._told)

    @cached_property
    def _told(self) -> tuple[tuple[Truth, float, tuple[bool, ...]], ...]:
        """Per frame its truth, the time that it carries [s], which pictures arrived."""
        path, T, wanted = self.path(TRUTH), len(TARGETS), self.frame_count
        names = [n for n in TRUTH_SCHEMA.names if not n.startswith(_LABELS_ONLY)]
        schema = pa.schema([TRUTH_SCHEMA.field(name) for name in names])
        table = read_table(path, schema, f"{T * wanted} rows ({wanted} frames)", T * wanted)
        try:
            rows = table.to_pylist()
        except ValueError as fault:
            raise BenchError(f"{path}: holds text that is not UTF-8.") from fault
        found: list[tuple[Truth, float, tuple[bool, ...]]] = []
        for index in range(wanted):
            mine = rows[T * index : T * (index + 1)]
            try:
                if any(row["frame_index"] != index for row in mine):
                    raise ValueError("frames must be in order, from 0")
                truth = truth_of_rows(mine)
                stamp_s = float(mine[0]["stamp_s"])
                numbers = np.r_[truth.time_s, stamp_s, truth.centres_m.ravel()]
                if not np.isfinite(np.r_[numbers, truth.velocities_mps.ravel()]).all():
                    raise ValueError("times, centres and velocities must be finite")
            except (KeyError, TypeError, ValueError) as fault:
                said = str(fault).rstrip(".")
                raise BenchError(f"{path}: frame {index}: {said}.") from fault
            came = tuple(bool(mine[0][f"arrived_{camera}"]) for camera in CAMERAS)
            found.append((truth, stamp_s, came))
        return tuple(found)

    def background(self) -> list[StereoFrame]:
        """The person-free frames."""
        return [
            StereoFrame(
                index,
                index / self.fps,
                tuple(
                    self.picture(f"background_{camera}", index, np.uint8, 3) for camera in CAMERAS
                ),
            )
            for index in range(self.background_count)
        ]

    def frame(self, index: int) -> StereoFrame:
        """The pictures of a frame, None where one did not arrive."""
        _, stamp_s, arrived = self._told[index]
        pictures = tuple(
            self.picture(camera, index, np.uint8, 3) if came else None
            for camera, came in zip(CAMERAS, arrived, strict=True)
        )
        return StereoFrame(index, stamp_s, pictures)

    def frames(self) -> Iterator[tuple[StereoFrame, Truth]]:
        """All frames in order with their truth, as `sim.sequence.Simulation.frames` gives them."""
        for index, truth in enumerate(self.truths):
            yield self.frame(index), truth

    def has(self, folder: str) -> bool:
        """Whether labels of this kind were written, e.g. "depth_left"."""
        return (self.folder / folder).is_dir()

    def clean(self, view: int, index: int) -> NDArray[np.uint8]:
        """The picture (h, w, 3) BGR of a view before the sensor's noise and blur."""
        return self.picture(f"clean_{CAMERAS[view]}", index, np.uint8, 3)

    def depth_m(self, view: int, index: int) -> NDArray[np.float32]:
        """Planar z (h, w) [m], NaN for nothing."""
        path = f"depth_{CAMERAS[view]}"
        return encode.depth_from_png(self.picture(path, index, np.uint16, 1))

    def seg(self, view: int, index: int) -> NDArray[np.uint8]:
        """Instance ids (h, w), as `instances` names them."""
        return self.picture(f"seg_{CAMERAS[view]}", index, np.uint8, 1)

    def amodal(self, view: int, index: int) -> NDArray[np.bool_]:
        """Amodal masks (T, h, w) in the order of TARGETS."""
        bits = self.picture(f"amodal_{CAMERAS[view]}", index, np.uint8, 1)
        return encode.amodal_from_png(bits, len(TARGETS))

    def rectified(self, view: int, index: int) -> Matches:
        """Disparity [px] and status of the rectified pair."""
        camera = CAMERAS[view]
        disparity = self.picture(f"disparity_{camera}", index, np.uint16, 1)
        status = self.picture(f"occlusion_{camera}", index, np.uint8, 1)
        return Matches(status, disparity_px=encode.disparity_from_png(disparity))

    def matches(self, view: int, index: int) -> Matches:
        """Places in the other view's picture [px], and status."""
        return encode.matches_from_png(
            self.picture(f"correspondence_{CAMERAS[view]}", index, np.uint16, 3)
        )

    def floats(self, view: int, index: int) -> dict[str, NDArray[np.float32]]:
        """What the label `float` holds of a view: depth_m, disparity_px, places_px."""
        camera = self.rig.cameras[view]
        path = self.path(f"float_{CAMERAS[view]}", picture_name(index, ".npz"))
        return encode.read_npz(path, (camera.height_px, camera.width_px))

    def path(self, *parts: str) -> Path:
        """A file of the sequence. Raises BenchError where it is none, or a link leads elsewhere."""
        path = self.folder.joinpath(*parts)
        check_inside(self.folder.parent, path)
        return path

    def picture(self, folder: str, index: int, dtype: type, channels: int) -> NDArray[Any]:
        """The picture of a folder, checked against the cameras' size."""
        path = self.path(folder, picture_name(index))
        if path.stat().st_size > MAX_PICTURE_BYTES:
            raise BenchError(f"{path}: is larger than {MAX_PICTURE_BYTES >> 20} MiB.")
        picture = encode.read_png(path, dtype, channels)
        camera = self.rig.left
        if picture.shape[:2] != (camera.height_px, camera.width_px):
            height, width = picture.shape[:2]
            raise BenchError(
                f"{path}: is {width}x{height}, the cameras are "
                f"{camera.width_px}x{camera.height_px}."
            )
        return picture

    def _cameras(self, key: str) -> StereoRig:
        path = self.folder / RIG
        try:
            left, right = (camera_of(self.rig_json[key][name]) for name in CAMERAS)
        except KeyError as fault:
            raise BenchError(f"{path}: {key}: lacks {fault}.") from fault
        except (TypeError, ValueError, OverflowError) as fault:
            said = str(fault).rstrip(".")
            raise BenchError(f"{path}: {key}: {said}.") from fault
        return StereoRig(left, right)


@dataclass(frozen=True, eq=False)
class Dataset:
    """A data set. sequences: the finished ones, in the manifest's order."""

    folder: Path
    manifest: Mapping[str, Any]
    sequences: tuple[Sequence, ...]

    @property
    def labels(self) -> tuple[str, ...]:
        """What was written beside the pictures and the truth."""
        return tuple(self.manifest["settings"]["labels"])


def open_dataset(folder: Path | str) -> Dataset:
    """Open a data set.

    Raises BenchError where it is none, of a newer version, or lacks a sequence that its manifest
    names.
    """
    folder = Path(folder)
    path = folder / MANIFEST
    if not path.is_file():
        raise BenchError(f"{folder}: is no data set (it has no {MANIFEST}).")
    check_inside(folder, path)
    manifest = read_json(path)
    if manifest.get("kind") != KIND:
        raise BenchError(f"{path}: is not the manifest of a data set.")
    if manifest.get("schema") != SCHEMA_VERSION:
        raise BenchError(
            f"{path}: is of version {manifest.get('schema')!r}, this is version {SCHEMA_VERSION}."
        )
    entries = manifest.get("sequences")
    settings = manifest.get("settings")
    if not isinstance(entries, list) or not isinstance(settings, dict):
        raise BenchError(f"{path}: has no list of sequences, or no settings.")
    if not isinstance(settings.get("labels"), list):
        raise BenchError(f"{path}: settings.labels must be a list.")
    sequences: dict[str, Sequence] = {}
    for number, entry in enumerate(entries):
        name = entry.get("folder") if isinstance(entry, dict) else None
        if not isinstance(name, str) or not is_sequence_name(name):
            raise BenchError(f"{path}: sequences.{number}: its folder must be named seq_NNNNNN.")
        if name in sequences:
            raise BenchError(f"{path}: sequences.{number}: names {name} a second time.")
        if (folder / name).is_symlink():
            raise BenchError(f"{folder / name}: is a link; a data set has its sequences in it.")
        if not (folder / name).is_dir():
            if manifest.get("complete"):
                raise BenchError(f"{folder / name}: is missing; the manifest names it.")
            continue
        sequences[name] = Sequence(folder / name, entry)
    return Dataset(folder, manifest, tuple(sequences.values()))


def check_inside(folder: Path, path: Path) -> None:
    """Raise BenchError unless a path is a plain file in a folder, links followed."""
    real = os.path.realpath(path)
    if not Path(real).is_relative_to(os.path.realpath(folder)):
        raise BenchError(
            f"{path}: is a link that leads out of the data set; copy it with its links followed "
            "(cp -rL)."
        )
    if not Path(real).exists():
        raise BenchError(f"{path}: is missing.")
    if not Path(real).is_file():
        raise BenchError(f"{path}: is no file.")


def read_json(path: Path) -> dict[str, Any]:
    """A JSON object. Raises BenchError where it is none."""
    try:
        if path.stat().st_size > MAX_JSON_BYTES:
            raise BenchError(f"{path}: is larger than {MAX_JSON_BYTES >> 20} MiB.")
        record = json.loads(path.read_text(encoding="utf-8"))
    except OSError as fault:
        raise BenchError(f"{path}: cannot be read: {fault.strerror}.") from fault
    except (ValueError, RecursionError) as fault:
        raise BenchError(f"{path}: is not JSON: {fault}.") from fault
    if not isinstance(record, dict):
        raise BenchError(f"{path}: is not a JSON object.")
    return record


def read_table(
    path: Path, schema: pa.Schema, wanted: str = "", rows: int | None = None
) -> pa.Table:
    """The columns of a schema of a Parquet file, which may have more.

    rows: how many it must have; wanted: the same in words. Raises BenchError where it has not.
    """
    try:
        with pq.ParquetFile(path) as file:
            there = file.metadata
            groups = [there.row_group(i).total_byte_size for i in range(there.num_row_groups)]
            if there.num_rows > MAX_ROWS or sum(groups) > MAX_TABLE_BYTES:
                raise BenchError(
                    f"{path}: has more than {MAX_ROWS} rows or {MAX_TABLE_BYTES >> 30} GiB."
                )
            missing = set(schema.names) - set(file.schema_arrow.names)
            if missing:
                raise BenchError(f"{path}: lacks the columns {', '.join(sorted(missing))}.")
            if rows is not None and there.num_rows != rows:
                raise BenchError(f"{path}: must have {wanted}, has {there.num_rows}.")
            return file.read(columns=schema.names).select(schema.names).cast(schema)
    except FileNotFoundError as fault:
        raise BenchError(f"{path}: is missing.") from fault
    except (OSError, KeyError, ValueError, pa.ArrowException) as fault:
        said = str(fault).partition("\n")[0].rstrip(".")
        raise BenchError(f"{path}: cannot be read as Parquet: {said}.") from fault


def camera_of(record: Mapping[str, Any]) -> Camera:
    """A camera from its plain numbers. Raises KeyError, TypeError or ValueError."""
    width, height = int(record["width_px"]), int(record["height_px"])
    if not (0 < width <= 20_000 and 0 < height <= 20_000):
        raise ValueError("width_px and height_px must be 1 to 20000")
    numbers = {
        name: np.array(record[name], np.float64) for name in ("K", "R_cw", "t_cw", "distortion")
    }
    if not all(np.isfinite(value).all() for value in numbers.values()):
        raise ValueError("the numbers of a camera must be finite")
    camera = Camera(width_px=width, height_px=height, **numbers)
    fx, fy = np.diag(camera.K)[:2]
    if not (fx > 0 and fy > 0 and np.array_equal(camera.K[2], [0.0, 0.0, 1.0])):
        raise ValueError("K must have focal lengths above 0 and the last row 0 0 1")
    R = camera.R_cw
    if np.abs(R @ R.T - np.eye(3)).max() > ORTHONORMAL or np.linalg.det(R) < 0:
        raise ValueError("R_cw must be a rotation")
    return camera


def _number(path: Path, record: Mapping[str, Any], key: str, least: float, most: float) -> float:
    value = record.get(key)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise BenchError(f"{path}: {key} must be a number.")
    # A whole number of JSON may have any length: compared before it becomes a float.
    if not (least <= value <= most and math.isfinite(value)):
        said = str(value)[:20]
        raise BenchError(f"{path}: {key} must be from {least:g} to {most:g}, got {said}.")
    return float(value)
