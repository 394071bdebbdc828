"""Tracks of real footage: tracks.csv and tracks.parquet, written frame by frame."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from pjpdaf.arrays import Floats
from pjpdaf.camera import Camera, distort_points, project
from pjpdaf.interfaces import Estimates
from pjpdaf.targets import HANDS, TARGETS
from sim.files import disk_faults

CSV, PARQUET = "tracks.csv", "tracks.parquet"
_NUMBERS = (
    *(f"{axis}_m" for axis in "xyz"),
    *(f"{axis}_{view}_px" for view in ("left", "right") for axis in "uv"),
    *(f"sd_{axis}_m" for axis in "xyz"),
)
EXCHANGE = "exchange_probability"  # the same in both hands' rows
COLUMNS = ("frame", "time_s", "target", *_NUMBERS[:3], "status", *_NUMBERS[3:], EXCHANGE)
SCHEMA = pa.schema(
    [
        (
            name,
            {"frame": pa.int64(), "target": pa.string(), "status": pa.string()}.get(
                name, pa.float64()
            ),
        )
        for name in COLUMNS
    ]
)
GROUP_FRAMES = 1000  # rows are held for this many frames before Parquet takes them
_DIGITS = {"px": 3}  # 1 um and 1/1000 px; else 6


def track_rows(
    index: int, time_s: float, cameras: Sequence[Camera], estimates: Estimates
) -> list[dict[str, Any]]:
    """One row a target, keys as `COLUMNS`; None where there is no number.

    Positions and standard deviations [m] are in the world of the cameras, which for real footage
    is the left camera's frame; pixels are those of the real, distorted pictures.
    """
    known = [bool(np.isfinite(position).all()) for position in estimates.positions_m]
    pixels = np.concatenate([_real_pixels(c, estimates.positions_m) for c in cameras], axis=1)
    variances = np.einsum("tii->ti", estimates.covariances_m2)
    sd_m = np.sqrt(np.maximum(variances, 0.0))
    rows = []
    for t, target in enumerate(TARGETS):
        numbers = np.concatenate([estimates.positions_m[t], pixels[t], sd_m[t]])
        row: dict[str, Any] = {"frame": index, "time_s": time_s, "target": target}
        row["status"] = estimates.status[t]
        for name, value in zip(_NUMBERS, numbers.tolist(), strict=True):
            row[name] = value if known[t] and math.isfinite(value) else None
        stated = estimates.exchange_probability
        row[EXCHANGE] = stated if t in HANDS and math.isfinite(stated) else None
        rows.append(row)
    return rows


def _real_pixels(camera: Camera, positions_m: Floats) -> Floats:
    """Pixels (T, 2) in the real picture, NaN where there is no position in front of the camera."""
    ideal = project(camera, positions_m)
    real = np.full_like(ideal, np.nan)
    seen = ~np.isnan(ideal[:, 0])
    real[seen] = distort_points(camera, ideal[seen])
    return real


class TrackWriter:
    """Writes both files into a folder; memory does not grow with their length.

    tracks.csv has every frame that `add` was called for, even where the process is killed;
    tracks.parquet is complete after `close`. Raises BenchError where the disk refuses,
    InfrastructureError where it is full.
    """

    def __init__(self, folder: Path, cameras: Sequence[Camera]) -> None:
        self._cameras = tuple(cameras)
        self._folder = folder
        self._held: list[dict[str, Any]] = []
        with disk_faults(folder, "the tracks"):
            self._parquet = pq.ParquetWriter(folder / PARQUET, SCHEMA, compression="zstd")
            self._csv = (folder / CSV).open("w", encoding="utf-8", newline="")
            self._csv.write(",".join(COLUMNS) + "\n")

    def add(self, index: int, time_s: float, estimates: Estimates) -> None:
        """The rows of one frame."""
        rows = track_rows(index, time_s, self._cameras, estimates)
        with disk_faults(self._folder, "the tracks"):
            # One write and a flush: a frame is in the file as a whole or not at all.
            self._csv.write("".join(_line(row) for row in rows))
            self._csv.flush()
            self._held += rows
            if len(self._held) >= GROUP_FRAMES * len(TARGETS):
                self._hand_over()

    def close(self) -> None:
        """Finish both files; safe to call twice."""
        with disk_faults(self._folder, "the tracks"):
            if not self._csv.closed:
                try:
                    self._hand_over()
                    self._parquet.close()
                finally:
                    self._csv.close()

    def _hand_over(self) -> None:
        if self._held:
            self._parquet.write_table(pa.Table.from_pylist(self._held, schema=SCHEMA))
            self._held = []


def _line(row: dict[str, Any]) -> str:
    return ",".join(_text(name, row[name]) for name in COLUMNS) + "\n"


def _text(name: str, value: Any) -> str:
    if value is None:
        return ""
    if isinstance(value, float):
        return f"{value:.{_DIGITS.get(name.rpartition('_')[2], 6)}f}"
    return str(value)
