"""The footer of a recording: what is known of the sequence as a whole, checked when it is read."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from itertools import chain
from typing import Any

from pjpdaf.camera import StereoRig
from sim.dataset.files.cameras import camera_of, camera_record
from sim.scene.world import CAMERAS
from sim.specs import SensorSpec

KIND, VERSION = "pjpdaf-bench recording", 1
MAX_SIDE_PX, MAX_FRAMES, MAX_SECONDS = 4096, 20_000, 1e6
MAX_EVENTS, MAX_TEXT = 100, 300  # of a frame; of a name


@dataclass(frozen=True, eq=False)
class Footer:
    """Facts of a recorded sequence.

    key: what decided the pictures, plain values; renderer: description of the OpenGL renderer;
    background_count: person-free frames, whose common light comes first; events: names of each
    frame's; block_sizes: bytes of each compressed block, in order: the light of the background,
    left and right, if there is any; that of every frame, 0 for a picture that was lost; the facts
    of all frames.
    """

    key: Mapping[str, Any]
    renderer: str
    fps: float
    redrawn: int
    seed: int
    background_count: int
    sensor: SensorSpec
    rig: StereoRig
    calibration: StereoRig
    events: tuple[tuple[str, ...], ...]
    block_sizes: tuple[int, ...]

    def to_json(self) -> bytes:
        """Plain JSON."""
        record = {
            "kind": KIND,
            "version": VERSION,
            "key": dict(self.key),
            "renderer": self.renderer,
            "fps": self.fps,
            "redrawn": self.redrawn,
            "seed": self.seed,
            "background_count": self.background_count,
            "sensor": asdict(self.sensor),
            "rig": [camera_record(camera) for camera in self.rig.cameras],
            "calibration": [camera_record(camera) for camera in self.calibration.cameras],
            "events": self.events,
            "block_sizes": self.block_sizes,
        }
        return json.dumps(record, separators=(",", ":"), ensure_ascii=False).encode()


def read_footer(data: bytes) -> Footer:
    """The inverse of `Footer.to_json`. Raises ValueError for anything else."""
    try:
        return _footer(json.loads(data))
    except (KeyError, TypeError, OverflowError, RecursionError) as fault:
        raise ValueError(f"has no {fault}") from fault


def _footer(record: Any) -> Footer:
    if not isinstance(record, dict) or (record["kind"], record["version"]) != (KIND, VERSION):
        raise ValueError(f"is not a recording of version {VERSION}")
    key, events, sizes = record["key"], record["events"], record["block_sizes"]
    if not (isinstance(key, dict) and isinstance(events, list) and isinstance(sizes, list)):
        raise ValueError("key, events and block_sizes must be an object and two lists")
    if not 1 <= len(events) <= MAX_FRAMES or any(len(names) > MAX_EVENTS for names in events):
        raise ValueError(f"must have 1 to {MAX_FRAMES} frames, each of at most {MAX_EVENTS} events")
    texts = [record["renderer"], *chain.from_iterable(events)]
    if not all(isinstance(text, str) and len(text) <= MAX_TEXT for text in texts):
        raise ValueError(f"renderer and events must be texts of at most {MAX_TEXT} characters")
    background = _whole(record["background_count"], "background_count", 1000)
    if len(sizes) != len(CAMERAS) * (len(events) + (background > 0)) + 1:
        raise ValueError("block_sizes: must be one for each picture, and one")
    sensor = dict(record["sensor"])
    sensor["white_balance_rgb"] = tuple(sensor["white_balance_rgb"])
    return Footer(
        key=key,
        renderer=record["renderer"],
        fps=_number(record["fps"], "fps"),
        redrawn=_whole(record["redrawn"], "redrawn", 1000),
        seed=_whole(record["seed"], "seed", 2**63),
        background_count=background,
        sensor=SensorSpec(**sensor),
        rig=_rig(record["rig"]),
        calibration=_rig(record["calibration"]),
        events=tuple(tuple(names) for names in events),
        block_sizes=tuple(_whole(size, "block_sizes", 2**32) for size in sizes),
    )


def _rig(cameras: Any) -> StereoRig:
    left, right = (camera_of(camera) for camera in cameras)
    size = left.width_px, left.height_px
    if max(size) > MAX_SIDE_PX or size != (right.width_px, right.height_px):
        raise ValueError(f"both cameras must be of one size, at most {MAX_SIDE_PX} pixels")
    return StereoRig(left, right)


def _whole(value: Any, name: str, most: int) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value <= most:
        raise ValueError(f"{name} must be a whole number from 0 to {most}")
    return value


def _number(value: Any, name: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ValueError(f"{name} must be a number")
    if not (0 < value <= MAX_SECONDS and math.isfinite(value)):
        raise ValueError(f"{name} must be above 0, at most {MAX_SECONDS:g}")
    return float(value)
