"""Files of anyone's tracks of a data set."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from scenarios.tables.sequences import read_sequences
from scenarios.tracks.tracks import COLUMNS, Tracks, TracksBuilder


def read_tracks(path: Path, frame_counts: Mapping[str, int]) -> dict[str, Tracks]:
    """Read the tracks of each sequence. frame_counts: frames of the data set's sequences, by name.

    A sequence without any row is absent. Raises BenchError naming file and line.
    """

    def builder(file: Path, name: str) -> TracksBuilder:
        return TracksBuilder(file, frame_counts[name])

    builders = read_sequences(path, list(frame_counts), COLUMNS, builder, "tracks")
    return {name: one.tracks() for name, one in builders.items()}
