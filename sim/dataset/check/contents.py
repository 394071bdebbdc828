"""The contents of a data set: its files, and the sequences that its manifest names."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from pjpdaf.errors import BenchError, FileError
from sim.dataset.check.fault import MISSING, Fault, FaultLog
from sim.dataset.check.files import FileTree, tree_of
from sim.dataset.files.conventions import conventions
from sim.dataset.files.layout import (
    CONVENTIONS,
    KIND,
    LABELS,
    MANIFEST,
    SCHEMA_VERSION,
    is_sequence_name,
)
from sim.dataset.files.reading import read_json
from sim.files import near_paths

# Numbers of conventions.json without which a label cannot be read.
_SCALES = (
    *(("depth", "unit_m"), ("disparity", "scale"), ("correspondence", "scale")),
    *(("normals", "scale"), ("flow", "scale"), ("semantic", "classes")),
)


@dataclass(frozen=True)
class DatasetContents:
    """Files and sequences. entries: of the manifest, labels: that should be there; by sequence."""

    tree: FileTree
    entries: Mapping[str, Mapping[str, Any]]
    labels: Mapping[str, tuple[str, ...]]

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the sequences whose folders are there."""
        return tuple(self.entries)


def read_contents(root: Path, log: FaultLog) -> DatasetContents:
    """Find the files and sequences of a data set, and check its manifest and conventions.

    Raises BenchError where there is no such folder, FileError where it is not a data set, or one of
    another version.
    """
    if not root.exists():
        raise BenchError(f"{root}: no such data set{near_paths(root)}")
    if not root.is_dir():
        raise FileError(root, "is not a data set: not a folder")
    tree = tree_of(root)
    there = sorted(
        {name for path in tree.plain if is_sequence_name(name := path.partition("/")[0])}
    )
    manifest: Mapping[str, Any] = {}
    if MANIFEST in tree.plain:
        manifest = log.read(partial(read_json, root / MANIFEST)) or {}
    elif there:
        log.add("manifest", [Fault(MANIFEST, MISSING)])
    if not there and manifest.get("kind") != KIND:
        raise FileError(root, f"is not a data set: has no {MANIFEST} and no sequences")
    if manifest:
        if manifest.get("kind") == KIND and manifest.get("schema") != SCHEMA_VERSION:
            version = manifest.get("schema")
            raise FileError(
                root / MANIFEST, f"is of version {version!r}, this is version {SCHEMA_VERSION}"
            )
        log.add("manifest", _manifest_faults(manifest))
    entries = _entries(manifest)
    if manifest:
        unlisted = [Fault(name, f"is not in {MANIFEST}") for name in there if name not in entries]
        missing = [Fault(name, MISSING) for name in entries if name not in there]
        log.add("manifest", unlisted + missing)
    if CONVENTIONS in tree.plain:
        stored = log.read(partial(read_json, root / CONVENTIONS))
        if stored is not None:
            log.add("conventions", _convention_faults(stored))
    settings = manifest.get("settings")
    named = settings.get("labels") if isinstance(settings, dict) else None
    labels = {}
    for name in there:
        with_files = (x for x in LABELS if any(tree.names(f"{name}/{sub}") for sub in LABELS[x]))
        labels[name] = tuple(
            [label for label in LABELS if label in named] if isinstance(named, list) else with_files
        )
    return DatasetContents(tree, {name: entries.get(name, {}) for name in there}, labels)


def _entries(manifest: Mapping[str, Any]) -> dict[str, Mapping[str, Any]]:
    """The manifest's entries by folder, those with a proper name."""
    listed = manifest.get("sequences")
    entries: dict[str, Mapping[str, Any]] = {}
    for entry in listed if isinstance(listed, list) else []:
        name = entry.get("folder") if isinstance(entry, dict) else None
        if isinstance(name, str) and is_sequence_name(name):
            entries.setdefault(name, entry)
    return entries


def _manifest_faults(manifest: Mapping[str, Any]) -> Iterator[Fault]:
    if manifest.get("kind") != KIND:
        yield Fault(MANIFEST, "is not the manifest of a data set")
    if manifest.get("complete") is not True:
        yield Fault(MANIFEST, "complete is not true: the data set was not made to its end")
    settings = manifest.get("settings")
    labels = settings.get("labels") if isinstance(settings, dict) else None
    if not isinstance(labels, list) or any(label not in LABELS for label in labels):
        yield Fault(MANIFEST, f"settings.labels is not a list of {', '.join(LABELS)}")
    listed, entries = manifest.get("sequences"), _entries(manifest)
    if not isinstance(listed, list) or len(entries) != len(listed):
        yield Fault(MANIFEST, "sequences is not a list of folders seq_NNNNNN, each once")
    frames = [entry.get("frames") for entry in entries.values()]
    whole = sum(n for n in frames if type(n) is int)
    if None in frames or whole != manifest.get("total_frames"):
        yield Fault(MANIFEST, "total_frames is not the sum of the sequences' frames")


def _convention_faults(stored: Mapping[str, Any]) -> Iterator[Fault]:
    """Check conventions.json: another version may explain more, but its scales may not differ."""
    known = conventions()
    for part, key in _SCALES:
        value = stored.get(part)
        if not isinstance(value, dict) or value.get(key) != known[part][key]:
            yield Fault(CONVENTIONS, f"{part}.{key} is not {known[part][key]}")
