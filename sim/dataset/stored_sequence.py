"""A sequence of a data set on disk: the records of a live simulation, and the labels.

All content is untrusted: nothing is executed or unpickled, and no path leads out of the data set.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from pjpdaf.camera import StereoRig
from pjpdaf.errors import FileError
from pjpdaf.frames import StereoFrame
from pjpdaf.targets import TARGETS
from sim.camera.normals import decoded
from sim.dataset.files import encode
from sim.dataset.files.cameras import camera_of
from sim.dataset.files.layout import (
    EVENTS,
    OBJECTS,
    RECIPE,
    RIG,
    SKELETON,
    TRUTH,
    picture_name,
)
from sim.dataset.files.reading import check_inside, read_json, read_table
from sim.dataset.files.tables import (
    OBJECTS_SCHEMA,
    SKELETON_SCHEMA,
    TRUTH_SCHEMA,
    truth_of_rows,
)
from sim.dataset.labels.instances import Instance
from sim.dataset.labels.records import Matches
from sim.scene.world import CAMERAS
from sim.truth import Truth

if TYPE_CHECKING:  # what plays a sequence is spared the time that pandas takes to load
    import pandas as pd

MAX_PICTURE_BYTES = 1 << 30
# Columns of truth.parquet that a Truth does not need, and that take long to read.
_LABELS_ONLY = ("keypoint", "amodal_box_", "occluded_by_", "truncation_")


@dataclass(frozen=True, eq=False)
class StoredSequence:
    """A sequence, read from its folder. Every method raises FileError for a damaged file.

    entry: of the manifest, empty where it has none.
    """

    folder: Path
    entry: Mapping[str, Any]

    @property
    def name(self) -> str:
        """Name of its folder."""
        return self.folder.name

    @cached_property
    def rig_json(self) -> dict[str, Any]:
        """Content of rig.json."""
        return read_json(self.path(RIG))

    @property
    def fps(self) -> float:
        """Frame rate [1/s]."""
        return _number(self.folder / RIG, self.rig_json, "fps", least=0.001, most=10_000.0)

    @property
    def frame_count(self) -> int:
        """Number of frames."""
        return int(_number(self.folder / RIG, self.rig_json, "frames", least=1, most=1e6))

    @property
    def background_count(self) -> int:
        """Number of person-free frames."""
        return int(_number(self.folder / RIG, self.rig_json, "background_frames", 0, 1e5))

    @property
    def redrawn(self) -> int:
        """Number of rejected draws of the seed (`sim.script.Performance`)."""
        return int(_number(self.folder / RIG, self.rig_json, "redrawn", 0, 1e5))

    @property
    def skew_s(self) -> float:
        """Delay of the right view's exposure after the left view's [s]."""
        return _number(self.folder / RIG, self.rig_json, "skew_s", least=0.0, most=10.0)

    @cached_property
    def rig(self) -> StereoRig:
        """The cameras, in the world."""
        return self._cameras("cameras")

    @cached_property
    def calibration(self) -> StereoRig:
        """The calibration that a tracker is given, with its errors if any."""
        return self._cameras("calibration")

    @cached_property
    def instances(self) -> tuple[Instance, ...]:
        """The instances whose ids are the pixels of `seg`."""
        path, listed = self.folder / RIG, self.rig_json.get("instances")
        try:
            return tuple(
                Instance(int(item["id"]), str(item["name"]), str(item["kind"]))
                for item in listed or ()
            )
        except (KeyError, TypeError, ValueError, OverflowError) as fault:
            raise FileError(path, "instances: is not a list of id, name, kind") from fault

    @cached_property
    def recipe(self) -> dict[str, Any]:
        """Content of recipe.json."""
        return read_json(self.path(RECIPE))

    @property
    def identity(self) -> dict[str, Any]:
        """Digests of room, body and rig in the recipe, empty where it has none."""
        identity = self.recipe.get("identity")
        return identity if isinstance(identity, dict) else {}

    @property
    def renderer(self) -> str:
        """Description of the renderer of its pictures, "" where the recipe has none."""
        made_with = self.recipe.get("made_with")
        renderer = made_with.get("renderer") if isinstance(made_with, dict) else None
        return renderer[:300] if isinstance(renderer, str) else ""

    @cached_property
    def events(self) -> dict[str, Any]:
        """Content of events.json."""
        return read_json(self.path(EVENTS))

    @cached_property
    def truth(self) -> pd.DataFrame:
        """truth.parquet: a row per frame and target."""
        return read_table(self.path(TRUTH), TRUTH_SCHEMA).to_pandas()

    @cached_property
    def objects(self) -> pd.DataFrame:
        """objects.parquet: a row per frame and object."""
        return read_table(self.path(OBJECTS), OBJECTS_SCHEMA).to_pandas()

    @cached_property
    def skeletons(self) -> pd.DataFrame:
        """skeletons.parquet: a row per frame and skeleton."""
        return read_table(self.path(SKELETON), SKELETON_SCHEMA).to_pandas()

    @property
    def truths(self) -> tuple[Truth, ...]:
        """The truth of every frame, in order, bit for bit as it was simulated."""
        return tuple(frame.truth for frame in self._frame_truths)

    @cached_property
    def _frame_truths(self) -> tuple[_FrameTruth, ...]:
        path, T, frames = self.path(TRUTH), len(TARGETS), self.frame_count
        names = [n for n in TRUTH_SCHEMA.names if not n.startswith(_LABELS_ONLY)]
        schema = pa.schema([TRUTH_SCHEMA.field(name) for name in names])
        table = read_table(path, schema, f"{T * frames} rows ({frames} frames)", T * frames)
        try:
            rows = table.to_pylist()
        except ValueError as fault:
            raise FileError(path, "holds text that is not UTF-8") from fault
        truths = []
        for index in range(frames):
            try:
                truths.append(_frame_truth(rows[T * index : T * (index + 1)], index))
            except (KeyError, TypeError, ValueError) as fault:
                cause = str(fault).rstrip(".")
                raise FileError(path, f"frame {index}: {cause}") from fault
        return tuple(truths)

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
        """The pictures of a frame, None where a picture did not arrive."""
        stored = self._frame_truths[index]
        pictures = tuple(
            self.picture(camera, index, np.uint8, 3) if arrived else None
            for camera, arrived in zip(CAMERAS, stored.arrived, strict=True)
        )
        return StereoFrame(index, stored.stamp_s, pictures)

    def frames(self) -> Iterator[tuple[StereoFrame, Truth]]:
        """Yield all frames in order with their truth, as `sim.sequence.Simulation.frames` does."""
        for index, truth in enumerate(self.truths):
            yield self.frame(index), truth

    def has(self, folder: str) -> bool:
        """Whether the sequence has this folder of labels, such as "depth_left"."""
        return (self.folder / folder).is_dir()

    def clean(self, view: int, index: int) -> NDArray[np.uint8]:
        """Picture (h, w, 3) BGR of a view without the sensor's effects."""
        return self.picture(f"clean_{CAMERAS[view]}", index, np.uint8, 3)

    def depth_m(self, view: int, index: int) -> NDArray[np.float32]:
        """Planar z (h, w) [m], NaN for nothing."""
        path = f"depth_{CAMERAS[view]}"
        return encode.depth_from_png(self.picture(path, index, np.uint16, 1))

    def seg(self, view: int, index: int) -> NDArray[np.uint8]:
        """Instance ids (h, w) of `instances`."""
        return self.picture(f"seg_{CAMERAS[view]}", index, np.uint8, 1)

    def amodal(self, view: int, index: int) -> NDArray[np.bool_]:
        """Amodal masks (T, h, w) in the order of TARGETS."""
        bits = self.picture(f"amodal_{CAMERAS[view]}", index, np.uint8, 1)
        return encode.amodal_from_png(bits, len(TARGETS))

    def rectified(self, view: int, index: int) -> Matches:
        """Disparity [px] and status in the rectified pair."""
        camera = CAMERAS[view]
        disparity = self.picture(f"disparity_{camera}", index, np.uint16, 1)
        status = self.picture(f"occlusion_{camera}", index, np.uint8, 1)
        return Matches(status, disparity_px=encode.disparity_from_png(disparity))

    def matches(self, view: int, index: int) -> Matches:
        """Positions in the other view's picture [px], and status."""
        return encode.matches_from_png(
            self.picture(f"correspondence_{CAMERAS[view]}", index, np.uint16, 3)
        )

    def classes(self, view: int, index: int) -> NDArray[np.uint8]:
        """Semantic classes (h, w) of `sim.dataset.labels.classes.CLASSES`."""
        return self.picture(f"semantic_{CAMERAS[view]}", index, np.uint8, 1)

    def normals(self, view: int, index: int) -> NDArray[np.float32]:
        """Unit normals (h, w, 3) in the camera's frame, NaN for nothing."""
        return decoded(self.picture(f"normals_{CAMERAS[view]}", index, np.uint8, 3)[..., ::-1])

    def flow(self, view: int, index: int, direction: str = "forward") -> Matches:
        """Positions [px] in the next frame's picture, or "backward" in that before, and status."""
        folder = f"flow_{direction}_{CAMERAS[view]}"
        return encode.matches_from_png(self.picture(folder, index, np.uint16, 3))

    def floats(self, view: int, index: int) -> dict[str, NDArray[np.float32]]:
        """Arrays of the label `float` of a view: depth_m, disparity_px, places_px."""
        camera = self.rig.cameras[view]
        path = self.path(f"float_{CAMERAS[view]}", picture_name(index, ".npz"))
        return encode.read_npz(path, (camera.height_px, camera.width_px))

    def path(self, *parts: str) -> Path:
        """Path of a file of the sequence, checked to be a plain file inside the data set."""
        path = self.folder.joinpath(*parts)
        check_inside(self.folder.parent, path)
        return path

    def picture(self, folder: str, index: int, dtype: type, channels: int) -> NDArray[Any]:
        """A picture of a folder; raises FileError for another size than the cameras'."""
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
            cause = str(fault).rstrip(".")
            raise FileError(path, f"{key}: {cause}") from fault
        return StereoRig(left, right)


@dataclass(frozen=True, eq=False)
class _FrameTruth:
    """A frame's truth, the time that the frame carries [s], and per view if its picture arrived."""

    truth: Truth
    stamp_s: float
    arrived: tuple[bool, ...]


def _frame_truth(rows: Sequence[Mapping[str, Any]], index: int) -> _FrameTruth:
    """Of a frame's rows of truth.parquet. Raises KeyError, TypeError or ValueError."""
    if any(row["frame_index"] != index for row in rows):
        raise ValueError("frames must be in order, from 0")
    truth = truth_of_rows(rows)
    stamp_s = float(rows[0]["stamp_s"])
    numbers = np.r_[truth.time_s, stamp_s, truth.centres_m.ravel(), truth.velocities_mps.ravel()]
    if not np.isfinite(numbers).all():
        raise ValueError("times, centres and velocities must be finite")
    arrived = tuple(bool(rows[0][f"arrived_{camera}"]) for camera in CAMERAS)
    return _FrameTruth(truth, stamp_s, arrived)


def _number(path: Path, record: Mapping[str, Any], key: str, least: float, most: float) -> float:
    value = record.get(key)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise FileError(path, f"{key} must be a number")
    # A whole number of JSON may have any length: compared before it becomes a float.
    if not (least <= value <= most and math.isfinite(value)):
        raise FileError(path, f"{key} must be from {least:g} to {most:g}, got {str(value)[:20]}")
    return float(value)
