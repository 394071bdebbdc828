"""Anyone's tracks of a data set: CSV or Parquet files, read row by row and checked.

One file with a column `sequence`, or a folder with a file a sequence: seq_000000.csv,
seq_000000.parquet or seq_000000/tracks.csv, as `track` writes it.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from pjpdaf.arrays import Floats
from pjpdaf.errors import BenchError
from pjpdaf.interfaces import STATUSES
from pjpdaf.targets import TARGETS
from scenarios.spec.suggestion import did_you_mean
from sim.dataset.files.layout import is_sequence_name

POSITION = ("x_m", "y_m", "z_m")
DEVIATION = ("sd_x_m", "sd_y_m", "sd_z_m")
NEEDED = ("frame", "target", *POSITION)
SUFFIXES = (".csv", ".parquet")
TRACKED, LOST = "tracked", "lost"
FARTHEST_M = 1e6
BATCH_ROWS = 10_000

Row = tuple[str, Mapping[str, Any]]  # where it stands, and its cells by column


@dataclass(frozen=True, eq=False)
class Tracks:
    """The tracks of one sequence of F frames and T targets.

    path: the file; positions_m (F, T, 3), in whatever frame the file has them, NaN where there is
    no estimate; sd_m (F, T, 3) standard deviations, NaN where they are not given; status (F, T) of
    `STATUSES`.
    """

    path: Path
    positions_m: Floats
    sd_m: Floats
    status: tuple[tuple[str, ...], ...]


def read_tracks(path: Path, frame_counts: Mapping[str, int]) -> dict[str, Tracks]:
    """The tracks by sequence; frame_counts: frames of each sequence of the data set.

    A sequence without any row is absent. Raises BenchError naming file and line.
    """
    if path.is_dir():
        return _of_folder(path, frame_counts)
    if not path.is_file():
        raise BenchError(f"{path}: no such file or folder.")
    if path.suffix.lower() not in SUFFIXES:
        raise BenchError(f"{path}: must end in {' or '.join(SUFFIXES)}.")
    builders = {name: _Builder(path, count) for name, count in frame_counts.items()}
    only = next(iter(frame_counts)) if len(frame_counts) == 1 else None
    needed = NEEDED if only else ("sequence", *NEEDED)
    for where, row in _rows(path, needed):
        name = row.get("sequence", only)
        if name not in builders:
            hint = did_you_mean(str(name), builders) or f"; there are {_listed(list(builders))}"
            raise BenchError(f"{where}: no sequence {str(name)[:60]!r} in the data set{hint}")
        builders[name].add(where, row)
    return {name: one.tracks() for name, one in builders.items() if one.rows}


def _of_folder(folder: Path, frame_counts: Mapping[str, int]) -> dict[str, Tracks]:
    found: dict[str, Path] = {}
    for path in sorted(folder.iterdir()):
        name, file = path.stem, path
        if path.is_dir() and is_sequence_name(path.name):
            name, file = path.name, path / "tracks.csv"
            if not file.is_file():
                raise BenchError(f"{path}: has no tracks.csv.")
        elif path.suffix.lower() not in SUFFIXES:
            continue
        if name not in frame_counts:
            raise BenchError(
                f"{path}: is named after no sequence of the data set; there are "
                f"{_listed(list(frame_counts))}"
            )
        if name in found:
            raise BenchError(f"{file}: {name} is in {found[name].name} already.")
        found[name] = file
    if not found:
        raise BenchError(
            f"{folder}: has no tracks: it must have files such as "
            f"{next(iter(frame_counts))}.csv or .parquet, one a sequence."
        )
    tracks = {}
    for name, path in found.items():
        builder = _Builder(path, frame_counts[name])
        for where, row in _rows(path, NEEDED):
            builder.add(where, row)
        tracks[name] = builder.tracks()
    return tracks


class _Builder:
    """Collects the rows of one sequence."""

    def __init__(self, path: Path, frames: int) -> None:
        self._path, self._frames = path, frames
        self._positions = np.full((frames, len(TARGETS), 3), np.nan)
        self._sd = np.full((frames, len(TARGETS), 3), np.nan)
        self._status = [[LOST] * len(TARGETS) for _ in range(frames)]
        self._seen: set[tuple[int, int]] = set()

    @property
    def rows(self) -> int:
        """How many were added."""
        return len(self._seen)

    def add(self, where: str, row: Mapping[str, Any]) -> None:
        """One row. Raises BenchError that begins with `where`."""
        frame = _frame(where, row["frame"], self._frames)
        target = row["target"]
        if target not in TARGETS:
            raise BenchError(
                f"{where}: target must be of {', '.join(TARGETS)}, got {str(target)[:40]!r}"
            )
        t = TARGETS.index(target)
        if (frame, t) in self._seen:
            raise BenchError(f"{where}: {target} of frame {frame} is there a second time")
        self._seen.add((frame, t))
        position = _triple(where, row, POSITION)
        deviation = _triple(where, row, DEVIATION)
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
        """What was collected."""
        return Tracks(self._path, self._positions, self._sd, tuple(map(tuple, self._status)))


def _frame(where: str, cell: Any, frames: int) -> int:
    number = _number(where, "frame", cell)
    if number is None or not number.is_integer():
        raise BenchError(f"{where}: frame must be a whole number, got {str(cell)[:40]!r}")
    if not 0 <= number < frames:
        raise BenchError(
            f"{where}: frame {number:.0f} is not in the sequence: its {frames} frames count from "
            f"0 to {frames - 1}"
        )
    return int(number)


def _triple(where: str, row: Mapping[str, Any], names: Sequence[str]) -> list[float] | None:
    """Three numbers, None where all three cells are empty or not there."""
    found = {name: _number(where, name, row.get(name)) for name in names}
    values = [value for value in found.values() if value is not None]
    if 0 < len(values) < len(names):
        empty = next(name for name, value in found.items() if value is None)
        raise BenchError(f"{where}: {empty} is empty; give all of {', '.join(names)} or none")
    return values or None


def _number(where: str, name: str, cell: Any) -> float | None:
    """A finite number, None for an empty cell."""
    if cell is None or cell == "":
        return None
    try:
        if isinstance(cell, bool) or (isinstance(cell, str) and "_" in cell):
            raise ValueError
        value = float(cell)
    except (TypeError, ValueError, OverflowError):
        raise BenchError(f"{where}: {name} must be a number, got {str(cell)[:40]!r}") from None
    if not math.isfinite(value):
        raise BenchError(
            f"{where}: {name} is {cell}; where there is no estimate, leave the row out, or its "
            "cells empty"
        )
    if abs(value) > FARTHEST_M:
        raise BenchError(f"{where}: {name} is {value:g}: metres are expected")
    return value


def _rows(path: Path, needed: Sequence[str]) -> Iterator[Row]:
    """Rows of a file. Raises BenchError where it is damaged or lacks a column."""
    read: Callable[[Path, Sequence[str]], Iterator[Row]]
    read = _rows_of_csv if path.suffix.lower() == ".csv" else _rows_of_parquet
    try:
        yield from read(path, needed)
    except OSError as fault:
        raise BenchError(f"{path}: cannot be read: {fault.strerror or fault}.") from fault


def _check_columns(where: str, names: Sequence[str], needed: Sequence[str]) -> None:
    missing = [name for name in needed if name not in names]
    if missing:
        there = ", ".join(names)[:120]
        raise BenchError(f"{where}: lacks the columns {', '.join(missing)}; there are: {there}")
    twice = [name for name in names if names.count(name) > 1]
    if twice:
        raise BenchError(f"{where}: has the column {twice[0]!r} twice")


def _rows_of_csv(path: Path, needed: Sequence[str]) -> Iterator[Row]:
    with path.open(encoding="utf-8-sig", newline="") as file:
        lines = csv.reader(file)
        try:
            names = [name.strip() for name in next(lines, [])]
            _check_columns(f"{path}:1", names, needed)
            for cells in lines:
                if not cells:
                    continue
                where = f"{path}:{lines.line_num}"
                if len(cells) != len(names):
                    raise BenchError(
                        f"{where}: has {len(cells)} cells, the first line has {len(names)}"
                    )
                yield where, {n: cell.strip() for n, cell in zip(names, cells, strict=True)}
        except csv.Error as fault:
            raise BenchError(f"{path}:{lines.line_num}: is no CSV: {fault}") from fault
        except UnicodeDecodeError as fault:
            raise BenchError(f"{path}:{lines.line_num + 1}: is not UTF-8 text") from fault


def _rows_of_parquet(path: Path, needed: Sequence[str]) -> Iterator[Row]:
    number = 0
    try:
        with pq.ParquetFile(path) as file:
            names = list(file.schema_arrow.names)
            _check_columns(str(path), names, needed)
            taken = [n for n in ("sequence", *NEEDED, "status", *DEVIATION) if n in names]
            for name in taken:
                kind = file.schema_arrow.field(name).type
                if pa.types.is_nested(kind):
                    raise BenchError(f"{path}: column {name!r} must be numbers or text, is {kind}")
            for batch in file.iter_batches(BATCH_ROWS, columns=taken):
                for row in batch.to_pylist():
                    number += 1
                    yield f"{path}: row {number}", row
    except (pa.ArrowException, UnicodeDecodeError) as fault:
        said = " ".join(str(fault).split())[:200].rstrip(".")
        raise BenchError(f"{path}: cannot be read as Parquet: {said}.") from fault


def _listed(names: Sequence[str]) -> str:
    return ", ".join(names) if len(names) <= 4 else f"{names[0]} to {names[-1]}"
