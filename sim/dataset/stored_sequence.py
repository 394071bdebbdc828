"""A sequence of a data set on disk: the records of a live simulation, and the labels."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as pa
from numpy.typing import NDArray

from pjpdaf.camera import StereoRig
from pjpdaf.errors import FileError
from pjpdaf.frames import StereoFrame
from pjpdaf.targets import TARGETS
from sim.dataset.files import encode
from sim.dataset.files.cameras import camera_of
from sim.dataset.files.layout import EVENTS, OBJECTS, RECIPE, RIG, TRUTH, picture_name
from sim.dataset.files.reading import check_inside, read_json, read_table
from sim.dataset.files.tables import OBJECTS_SCHEMA, TRUTH_SCHEMA, truth_of_rows
from sim.dataset.labels.instances import Instance
from sim.dataset.labels.records import Matches
from sim.scene.world import CAMERAS
from sim.truth import Truth

MAX_PICTURE_BYTES = 1 << 30
# Columns of truth.parquet that a Truth does not need, and that take long to read.
_LABELS_ONLY = ("keypoint", "amodal_box_", "occluded_by_", "truncation_")


@dataclass(frozen=True, eq=False)
class StoredSequence:
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
            raise FileError(path, "instances: is not a list of id, name, kind") from fault

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
            raise FileError(path, "holds text that is not UTF-8") from fault
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
                raise FileError(path, f"frame {index}: {said}") from fault
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
            raise FileError(path, f"is larger than {MAX_PICTURE_BYTES >> 20} MiB")
        picture = encode.read_png(path, dtype, channels)
        camera = self.rig.left
        if picture.shape[:2] != (camera.height_px, camera.width_px):
            height, width = picture.shape[:2]
            raise FileError(
                path, f"is {width}x{height}, the cameras are {camera.width_px}x{camera.height_px}"
            )
        return picture

    def _cameras(self, key: str) -> StereoRig:
        path = self.folder / RIG
        try:
            left, right = (camera_of(self.rig_json[key][name]) for name in CAMERAS)
        except KeyError as fault:
            raise FileError(path, f"{key}: lacks {fault}") from fault
        except (TypeError, ValueError, OverflowError) as fault:
            said = str(fault).rstrip(".")
            raise FileError(path, f"{key}: {said}") from fault
        return StereoRig(left, right)


def _number(path: Path, record: Mapping[str, Any], key: str, least: float, most: float) -> float:
    value = record.get(key)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise FileError(path, f"{key} must be a number")
    # A whole number of JSON may have any length: compared before it becomes a float.
    if not (least <= value <= most and math.isfinite(value)):
        said = str(value)[:20]
        raise FileError(path, f"{key} must be from {least:g} to {most:g}, got {said}")
    return float(value)
