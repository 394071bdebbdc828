"""Anyone's tracks of a data set: CSV or Parquet files, read row by row and checked.

One file with a column `sequence`, or a folder with a file a sequence: seq_000000.csv,
seq_000000.parquet or seq_000000/tracks.csv, as `track` writes it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from pjpdaf.errors import BenchError
from scenarios.spec.suggestion import did_you_mean
from scenarios.tracks.rows import NEEDED, SUFFIXES, read_rows
from scenarios.tracks.tracks import Tracks, TracksBuilder
from sim.dataset.files.layout import is_sequence_name


def read_tracks(path: Path, frame_counts: Mapping[str, int]) -> dict[str, Tracks]:
    """Read the tracks of each sequence. frame_counts: frames of the data set's sequences, by name.

    A sequence without any row is absent. Raises BenchError naming file and line.
    """
    if path.is_dir():
        return _read_folder(path, frame_counts)
    if not path.is_file():
        raise BenchError(f"{path}: no such file or folder.")
    if path.suffix.lower() not in SUFFIXES:
        raise BenchError(f"{path}: must end in {' or '.join(SUFFIXES)}.")
    builders = {name: TracksBuilder(path, count) for name, count in frame_counts.items()}
    only = next(iter(frame_counts)) if len(frame_counts) == 1 else None
    needed = NEEDED if only else ("sequence", *NEEDED)
    for where, row in read_rows(path, needed):
        name = row.get("sequence", only)
        if name not in builders:
            hint = did_you_mean(str(name), builders) or f"; there are {_listed(list(builders))}"
            raise BenchError(f"{where}: no sequence {str(name)[:60]!r} in the data set{hint}")
        builders[name].add(where, row)
    return {name: builder.tracks() for name, builder in builders.items() if builder.rows}


def _read_folder(folder: Path, frame_counts: Mapping[str, int]) -> dict[str, Tracks]:
    files: dict[str, Path] = {}
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
        if name in files:
            raise BenchError(f"{file}: {name} is in {files[name].name} already.")
        files[name] = file
    if not files:
        raise BenchError(
            f"{folder}: has no tracks: it must have files such as "
            f"{next(iter(frame_counts))}.csv or .parquet, one a sequence."
        )
    tracks = {}
    for name, path in files.items():
        builder = TracksBuilder(path, frame_counts[name])
        for where, row in read_rows(path, NEEDED):
            builder.add(where, row)
        tracks[name] = builder.tracks()
    return tracks


def _listed(names: Sequence[str]) -> str:
    return ", ".join(names) if len(names) <= 4 else f"{names[0]} to {names[-1]}"
