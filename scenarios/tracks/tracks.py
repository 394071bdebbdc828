"""The tracks of a sequence, collected from checked rows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.errors import BenchError
from pjpdaf.interfaces import STATUSES
from pjpdaf.targets import HANDS, TARGETS
from scenarios.tables.cells import read_frame, read_number
from scenarios.tables.rows import Columns

POSITION = ("x_m", "y_m", "z_m")
DEVIATION = ("sd_x_m", "sd_y_m", "sd_z_m")
EXCHANGE = "exchange_probability"
COLUMNS = Columns(("frame", "target", *POSITION), ("status", *DEVIATION, EXCHANGE))
TRACKED, LOST = "tracked", "lost"


@dataclass(frozen=True, eq=False)
class Tracks:
    """The tracks of one sequence of F frames and T targets.

    path: the file; positions_m (F, T, 3), in the frame of the file, NaN where there is no
    estimate; sd_m (F, T, 3) standard deviations, NaN where not given; status (F, T) of
    `STATUSES`; exchange_probability (F,), NaN where not given.
    """

    path: Path
    positions_m: Floats
    sd_m: Floats
    status: tuple[tuple[str, ...], ...]
    exchange_probability: Floats


class TracksBuilder:
    """Collects the rows of a sequence of `frames` frames from the file `path`."""

    def __init__(self, path: Path, frames: int) -> None:
        self._path, self._frames = path, frames
        self._positions = np.full((frames, len(TARGETS), 3), np.nan)
        self._sd = np.full((frames, len(TARGETS), 3), np.nan)
        self._status = [[LOST] * len(TARGETS) for _ in range(frames)]
        self._exchange = np.full(frames, np.nan)
        self._seen: set[tuple[int, int]] = set()

    @property
    def rows(self) -> int:
        """The number of rows added."""
        return len(self._seen)

    def add(self, where: str, row: Mapping[str, Any]) -> None:
        """Add a row. where: its place, with which messages begin. Raises BenchError."""
        frame = read_frame(where, row["frame"], self._frames)
        target = row["target"]
        if target not in TARGETS:
            raise BenchError(
                f"{where}: target must be of {', '.join(TARGETS)}, got {str(target)[:40]!r}"
            )
        t = TARGETS.index(target)
        if (frame, t) in self._seen:
            raise BenchError(f"{where}: {target} of frame {frame} is there a second time")
        self._seen.add((frame, t))
        position = _three_numbers(where, row, POSITION)
        deviation = _three_numbers(where, row, DEVIATION)
        status = row.get("status") or (LOST if position is None else TRACKED)
        if status not in STATUSES:
            raise BenchError(
                f"{where}: status must be of {', '.join(STATUSES)}, got {str(status)[:40]!r}"
            )
        if position is None and status not in (LOST, "waiting"):
            raise BenchError(f"{where}: {target} is {status} but has no {', '.join(POSITION)}")
        if deviation is not None and min(deviation) < 0:
            raise BenchError(f"{where}: {', '.join(DEVIATION)} must be 0 or more")
        exchange = read_number(where, EXCHANGE, row.get(EXCHANGE))
        if exchange is not None:
            self._add_exchange(where, frame, t, exchange)
        self._status[frame][t] = str(status)
        if position is not None:
            self._positions[frame, t] = position
            if deviation is not None:
                self._sd[frame, t] = deviation

    def _add_exchange(self, where: str, frame: int, t: int, exchange: float) -> None:
        if t not in HANDS:
            raise BenchError(f"{where}: {EXCHANGE} goes into the hands' rows, not the head's")
        if not 0.0 <= exchange <= 1.0:
            raise BenchError(f"{where}: {EXCHANGE} must be from 0 to 1, got {exchange:g}")
        if np.isfinite(self._exchange[frame]) and self._exchange[frame] != exchange:
            raise BenchError(
                f"{where}: {EXCHANGE} is {exchange:g}, of the other hand it is another"
            )
        self._exchange[frame] = exchange

    def tracks(self) -> Tracks:
        """The collected tracks."""
        status = tuple(map(tuple, self._status))
        return Tracks(self._path, self._positions, self._sd, status, self._exchange)


def _three_numbers(where: str, row: Mapping[str, Any], names: Sequence[str]) -> list[float] | None:
    """Read three numbers; None where all three cells are empty or missing."""
    numbers = {name: read_number(where, name, row.get(name), "metres are") for name in names}
    values = [value for value in numbers.values() if value is not None]
    if 0 < len(values) < len(names):
        empty = next(name for name, value in numbers.items() if value is None)
        raise BenchError(f"{where}: {empty} is empty; give all of {', '.join(names)} or none")
    return values or None
