"""Opens a data set: its manifest and its finished sequences.

All content is untrusted: nothing is executed or unpickled, and no path leads out of the folder.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pjpdaf.errors import BenchError, FileError
from sim.dataset.files.layout import (
    KIND,
    MANIFEST,
    OLDEST_VERSION,
    SCHEMA_VERSION,
    is_sequence_name,
)
from sim.dataset.files.reading import check_inside, read_json
from sim.dataset.stored_sequence import StoredSequence
from sim.files import near_paths


@dataclass(frozen=True, eq=False)
class Dataset:
    """A data set. sequences: those that are finished, in the order of the manifest."""

    folder: Path
    manifest: Mapping[str, Any]
    sequences: tuple[StoredSequence, ...]

    @property
    def labels(self) -> tuple[str, ...]:
        """Labels beside the pictures and the truth."""
        return tuple(self.manifest["settings"]["labels"])


def open_dataset(folder: Path | str) -> Dataset:
    """Open a data set.

    Raises BenchError where there is no such folder, FileError where it is not a data set, of a
    newer version, or lacks a sequence that its manifest names.
    """
    folder = Path(folder)
    path = folder / MANIFEST
    if not folder.exists():
        raise BenchError(f"{folder}: no such data set{near_paths(folder)}")
    if not path.is_file():
        raise FileError(folder, f"is not a data set: has no {MANIFEST}")
    check_inside(folder, path)
    manifest = read_json(path)
    if manifest.get("kind") != KIND:
        raise FileError(path, "is not the manifest of a data set")
    version = manifest.get("schema")
    if type(version) is not int or not OLDEST_VERSION <= version <= SCHEMA_VERSION:
        raise FileError(path, f"is of version {version!r}, this is version {SCHEMA_VERSION}")
    entries = manifest.get("sequences")
    settings = manifest.get("settings")
    if not isinstance(entries, list) or not isinstance(settings, dict):
        raise FileError(path, "has no list of sequences, or no settings")
    if not isinstance(settings.get("labels"), list):
        raise FileError(path, "settings.labels must be a list")
    sequences: dict[str, StoredSequence] = {}
    for number, entry in enumerate(entries):
        name = entry.get("folder") if isinstance(entry, dict) else None
        if not isinstance(name, str) or not is_sequence_name(name):
            raise FileError(path, f"sequences.{number}: its folder must be named seq_NNNNNN")
        if name in sequences:
            raise FileError(path, f"sequences.{number}: names {name} a second time")
        if (folder / name).is_symlink():
            raise FileError(folder / name, "is a link; a data set has its sequences in it")
        if not (folder / name).is_dir():
            if manifest.get("complete"):
                raise FileError(folder / name, "is missing; the manifest names it")
            continue
        sequences[name] = StoredSequence(folder / name, entry)
    return Dataset(folder, manifest, tuple(sequences.values()))
