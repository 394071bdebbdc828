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
from pjpdaf.targets import TARGETS
from scenarios.tables.cells import read_frame, read_number
from scenarios.tables.rows import Columns

POSITION = ("x_m", "y_m", "z_m")
DEVIATION = ("sd_x_m", "sd_y_m", "sd_z_m")
COLUMNS = Columns(("frame", "target", *POSITION), ("status", *DEVIATION))
TRACKED, LOST = "tracked", "lost"


@dataclass(frozen=True, eq=False)
class Tracks:
    """The tracks of one sequence of F frames and T targets.

    path: the file; positions_m (F, T, 3), in the frame of the file, NaN where there is no
    estimate; sd_m (F, T, 3) standard deviations, NaN where not given; status (F, T) of
    `STATUSES`.
    """

    path: Path
    positions_m: Floats
    sd_m: Floats
    status: tuple[tuple[str, ...], ...]


class TracksBuilder:
    """Collects the rows of a sequence of `frames` frames from the file `path`."""

    def __init__(self, path: Path, frames: int) -> None:
        self._path, self._frames = path, frames
        self._positions = np.full((frames, len(TARGETS), 3), np.nan)
        self._sd = np.full((frames, len(TARGETS), 3), np.nan)
        self._status = [[LOST] * len(TARGETS) for _ in range(frames)]
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
        self._status[frame][t] = str(status)
        if position is not None:
            self._positions[frame, t] = position
            if deviation is not None:
                self._sd[frame, t] = deviation

    def tracks(self) -> Tracks:
        """The collected tracks."""
        return Tracks(self._path, self._positions, self._sd, tuple(map(tuple, self._status)))


def _three_numbers(where: str, row: Mapping[str, Any], names: Sequence[str]) -> list[float] | None:
    """Read three numbers; None where all three cells are empty or missing."""
    numbers = {name: read_number(where, name, row.get(name), "metres are") for name in names}
    values = [value for value in numbers.values() if value is not None]
    if 0 < len(values) < len(names):
        empty = next(name for name, value in numbers.items() if value is None)
        raise BenchError(f"{where}: {empty} is empty; give all of {', '.join(names)} or none")
    return values or None
