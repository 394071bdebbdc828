"""Files of a data set's tracks or detections: one file, or a folder with a file a sequence.

One file has a column `sequence`, unless there is one sequence alone. A folder has a file each:
seq_000000.csv, seq_000000.parquet, or a folder seq_000000 with a file of a given name.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, Protocol, TypeVar

from pjpdaf.errors import BenchError
from scenarios.spec.suggestion import did_you_mean
from scenarios.tables.rows import SUFFIXES, Columns, read_rows
from sim.dataset.files.layout import is_sequence_name
from sim.files import near_paths


class Builder(Protocol):
    """Collects the rows of a sequence."""

    @property
    def rows(self) -> int:
        """The number of rows added."""
        ...

    def add(self, where: str, row: Mapping[str, Any]) -> None:
        """Add a row. where: its place, with which messages begin. Raises BenchError."""
        ...


B = TypeVar("B", bound=Builder)


def read_sequences(
    path: Path,
    names: Sequence[str],
    columns: Columns,
    builder: Callable[[Path, str], B],
    noun: str,
    whole: str = "the data set",
) -> dict[str, B]:
    """Read a file or folder into a builder for each sequence that has rows in it.

    names: of the sequences; builder: makes one for a file and a sequence; noun: of the content,
    for messages, and the name of the CSV file in a sequence's folder; whole: what the sequences
    are of, for messages. Raises BenchError.
    """
    if path.is_dir():
        return _read_folder(path, names, columns, builder, noun)
    if not path.is_file():
        raise BenchError(f"{path}: no such file or folder{near_paths(path)}")
    if path.suffix.lower() not in SUFFIXES:
        raise BenchError(f"{path}: must end in {' or '.join(SUFFIXES)}.")
    builders = {name: builder(path, name) for name in names}
    only = names[0] if len(names) == 1 else None
    for where, row in read_rows(path, columns, sequence=only is None):
        name = row.get("sequence", only)
        if name not in builders:
            hint = did_you_mean(str(name), builders) or f"; there are {_listed(names)}"
            if only is not None:
                hint = f"; it is one sequence, {only}: leave the column `sequence` out"
            raise BenchError(f"{where}: no sequence {str(name)[:60]!r} in {whole}{hint}")
        builders[name].add(where, row)
    return {name: one for name, one in builders.items() if one.rows}


def _read_folder(
    folder: Path,
    names: Sequence[str],
    columns: Columns,
    builder: Callable[[Path, str], B],
    noun: str,
) -> dict[str, B]:
    files: dict[str, Path] = {}
    for path in sorted(folder.iterdir()):
        name, file = path.stem, path
        if path.is_dir() and is_sequence_name(path.name):
            name, file = path.name, path / f"{noun}.csv"
            if not file.is_file():
                raise BenchError(f"{path}: has no {noun}.csv.")
        elif path.suffix.lower() not in SUFFIXES:
            continue
        if name not in names:
            raise BenchError(
                f"{path}: is named after no sequence of the data set; there are {_listed(names)}"
            )
        if name in files:
            raise BenchError(f"{file}: {name} is in {files[name].name} already.")
        files[name] = file
    if not files:
        raise BenchError(
            f"{folder}: has no {noun}: it must have files such as {names[0]}.csv or .parquet, one "
            "a sequence."
        )
    builders = {}
    for name, path in files.items():
        builders[name] = builder(path, name)
        for where, row in read_rows(path, columns):
            builders[name].add(where, row)
    return builders


def _listed(names: Sequence[str]) -> str:
    return ", ".join(names) if len(names) <= 4 else f"{names[0]} to {names[-1]}"
