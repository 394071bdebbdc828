"""Rows of files of tracks or detections, CSV or Parquet, read one by one."""

from __future__ import annotations

import csv
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from pjpdaf.errors import BenchError
from sim.parquet import TooLarge, read_bounded

SUFFIXES = (".csv", ".parquet")
BATCH_ROWS = 10_000
MAX_BYTES = 256 << 20  # of a CSV file
MAX_COLUMNS = 1000
MAX_ROWS = 2_000_000

TableRow = tuple[str, Mapping[str, Any]]  # its place, for messages, and its cells by column


@dataclass(frozen=True)
class Columns:
    """The columns of a kind of file, beside `sequence`: all others are passed over."""

    needed: tuple[str, ...]
    optional: tuple[str, ...] = ()


def read_rows(path: Path, columns: Columns, *, sequence: bool = False) -> Iterator[TableRow]:
    """Yield the rows of a file. sequence: the column `sequence` is needed, too.

    Raises BenchError where the file is damaged or lacks a column.
    """
    needed = ("sequence", *columns.needed) if sequence else columns.needed
    try:
        if path.suffix.lower() == ".csv":
            yield from _rows_of_csv(path, needed)
        else:
            yield from _rows_of_parquet(path, needed, columns.optional)
    except OSError as fault:
        raise BenchError(f"{path}: cannot be read: {fault.strerror or fault}.") from fault


def _check_columns(where: str, names: Sequence[str], needed: Sequence[str]) -> None:
    missing = [name for name in needed if name not in names]
    if missing:
        noun = "column" if len(missing) == 1 else "columns"
        hint = f"there are: {', '.join(name[:60] for name in names[:20])[:400]}"
        if missing == ["sequence"]:
            hint = (
                "a file without it is of one sequence: name it FOLDER/seq_000000.csv after its "
                "sequence, and give FOLDER"
            )
        raise BenchError(f"{where}: lacks the {noun} {', '.join(missing)}; {hint}")
    if len(names) > MAX_COLUMNS:
        raise BenchError(f"{where}: has more than {MAX_COLUMNS} columns")
    counts = Counter(names)
    twice = [name for name in names if counts[name] > 1]
    if twice:
        raise BenchError(f"{where}: has the column {twice[0][:60]!r} twice")


def _rows_of_csv(path: Path, needed: Sequence[str]) -> Iterator[TableRow]:
    if path.stat().st_size > MAX_BYTES:
        raise BenchError(f"{path}: is larger than {MAX_BYTES >> 20} MiB.")
    with path.open(encoding="utf-8-sig", newline="") as file:
        lines = csv.reader(file)
        try:
            names = [name.strip() for name in next(lines, [])]
            _check_columns(f"{path}:1", names, needed)
            for number, cells in enumerate(lines):
                if not cells:
                    continue
                if number >= MAX_ROWS:
                    raise BenchError(f"{path}: has more than {MAX_ROWS} rows.")
                where = f"{path}:{lines.line_num}"
                if len(cells) != len(names):
                    raise BenchError(
                        f"{where}: has {len(cells)} cells, the first line has {len(names)}"
                    )
                yield where, {n: cell.strip() for n, cell in zip(names, cells, strict=True)}
        except csv.Error as fault:
            raise BenchError(f"{path}:{lines.line_num}: is not CSV: {fault}") from fault
        except UnicodeDecodeError as fault:
            raise BenchError(f"{path}:{lines.line_num + 1}: is not UTF-8 text") from fault


def _rows_of_parquet(
    path: Path, needed: Sequence[str], optional: Sequence[str]
) -> Iterator[TableRow]:
    number = 0
    try:
        with pq.ParquetFile(path) as file:
            names = list(file.schema_arrow.names)
            _check_columns(str(path), names, needed)
            wanted = dict.fromkeys(("sequence", *needed, *optional))
            taken = [name for name in wanted if name in names]
            for name in taken:
                kind = file.schema_arrow.field(name).type
                if pa.types.is_nested(kind):
                    raise BenchError(f"{path}: column {name!r} must be numbers or text, is {kind}")
            if file.metadata.num_rows > MAX_ROWS:
                raise BenchError(f"{path}: has more than {MAX_ROWS} rows.")
        for batch in read_bounded(path, taken).to_batches(BATCH_ROWS):
            for row in batch.to_pylist():
                number += 1
                yield f"{path}: row {number}", row
    except TooLarge as fault:
        raise BenchError(f"{path}: {fault}.") from None
    except (pa.ArrowException, ValueError) as fault:
        reason = " ".join(str(fault).split())[:200].rstrip(".")
        raise BenchError(f"{path}: cannot be read as Parquet: {reason}.") from fault
