"""Proves a copy of a data set, from its files alone: every fault, named with its file.

Nothing here asks how the labels were made. What one file says is held against what others say: the
checksums, the cameras against the calibration, the masks against what truth.parquet counts in
them, the depth against the truth's surfaces, the other view's depth, the disparity and the
correspondence, the pictures against the depth, the exports against the sequences.
"""

from __future__ import annotations

import multiprocessing
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pjpdaf.errors import BenchError, InfrastructureError
from sim.dataset.check.exports import export_faults
from sim.dataset.check.fault import MISSING, Fault, fault_of
from sim.dataset.check.files import Sums, Tree, damaged, listing_faults, sums_of, tree_of
from sim.dataset.check.sequence import Checked, check_sequence
from sim.dataset.files.layout import (
    CONVENTIONS,
    KIND,
    LABELS,
    MANIFEST,
    SCHEMA_VERSION,
    conventions,
    is_sequence_name,
)
from sim.dataset.files.reading import read_json
from sim.dataset.stored_sequence import StoredSequence

# Numbers of conventions.json without which a label cannot be read.
_SCALES = (("depth", "unit_m"), ("disparity", "scale"), ("correspondence", "scale"))


def verify(
    dataset_folder: Path | str,
    *,
    sums: bool = True,
    on_sequence: Callable[[str], None] = lambda name: None,
    jobs: int = 1,
) -> list[Fault]:
    """All faults of a data set, sorted by file; none where it is whole and agrees with itself.

    sums: read all files to compare their SHA-256 as well; on_sequence is called with the name of
    each sequence once it is checked; jobs: worker processes. Raises BenchError where the folder is
    no data set at all, or one of a newer version, InfrastructureError where a worker dies.
    """
    root = Path(dataset_folder)
    plan = _plan(root)
    listed = sums_of(plan.tree, plan.names)
    faults = [*plan.faults, *listed.faults]
    faults += listing_faults(plan.tree, listed, plan.names)
    if sums:
        top = [path for path in plan.tree.plain if path.partition("/")[0] not in plan.names]
        faults += damaged(plan.tree, listed, top)
    numbers = {}
    for name, checked in _checked(plan, listed, sums, jobs):
        faults += checked.faults
        numbers[name] = checked.numbers
        on_sequence(name)
    faults += export_faults(plan.tree, numbers)
    return sorted(set(faults))


@dataclass(frozen=True)
class _Plan:
    """What is to be checked. labels: by sequence."""

    tree: Tree
    entries: Mapping[str, Mapping[str, Any]]
    labels: Mapping[str, tuple[str, ...]]
    faults: tuple[Fault, ...]

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(self.entries)


def _checked(plan: _Plan, sums: Sums, hash_files: bool, jobs: int) -> Iterator[tuple[str, Checked]]:
    """The sequences in order, each by a worker where there are several."""
    plain: dict[str, set[str]] = {name: set() for name in plan.names}
    for path in plan.tree.plain:
        if (name := path.partition("/")[0]) in plain:
            plain[name].add(path)
    work = []
    for name in plan.names:
        digests = {path: sums.digests[path] for path in plain[name] & set(sums.digests)}
        work.append(
            (
                StoredSequence(plan.tree.root / name, plan.entries[name]),
                Tree(plan.tree.root, frozenset(plain[name]), frozenset()),
                Sums(digests, ()),
                plan.labels[name],
                hash_files,
            )
        )
    if jobs <= 1 or len(work) <= 1:
        for name, task in zip(plan.names, work, strict=True):
            yield name, check_sequence(*task)
        return
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(min(jobs, len(work)), mp_context=context) as pool:
        waiting = [pool.submit(check_sequence, *task) for task in work]
        try:
            for name, result in zip(plan.names, waiting, strict=True):
                yield name, result.result()
        except BrokenProcessPool as fault:
            raise InfrastructureError(
                "a worker process died, likely for lack of memory: take fewer of them (--jobs)."
            ) from fault


def _plan(root: Path) -> _Plan:
    """The manifest, as far as it can be read, and the folders that are there."""
    if not root.is_dir():
        raise BenchError(f"{root}: is no data set (it is no folder).")
    tree = tree_of(root)
    there = sorted(
        {name for path in tree.plain if is_sequence_name(name := path.partition("/")[0])}
    )
    faults: list[Fault] = []
    manifest: Mapping[str, Any] = {}
    if MANIFEST in tree.plain:
        try:
            manifest = read_json(root / MANIFEST)
        except BenchError as error:
            faults.append(fault_of(error, root))
    elif there:
        faults.append(Fault(MANIFEST, MISSING))
    if not there and manifest.get("kind") != KIND:
        raise BenchError(f"{root}: is no data set (it has no {MANIFEST} and no sequences).")
    if manifest:
        if manifest.get("kind") == KIND and manifest.get("schema") != SCHEMA_VERSION:
            version = manifest.get("schema")
            raise BenchError(
                f"{root / MANIFEST}: is of version {version!r}, this is version {SCHEMA_VERSION}."
            )
        faults += _manifest_faults(manifest)
    entries = _entries(manifest)
    if manifest:
        faults += [Fault(n, f"is not in {MANIFEST}") for n in there if n not in entries]
        faults += [Fault(n, MISSING) for n in entries if n not in there]
    faults += _convention_faults(tree)
    settings = manifest.get("settings")
    named = settings.get("labels") if isinstance(settings, dict) else None
    labels = {}
    for name in there:
        found = (f for f in LABELS if any(tree.names(f"{name}/{sub}") for sub in LABELS[f]))
        labels[name] = tuple(
            [label for label in LABELS if label in named] if isinstance(named, list) else found
        )
    return _Plan(tree, {name: entries.get(name, {}) for name in there}, labels, tuple(faults))


def _entries(manifest: Mapping[str, Any]) -> dict[str, Mapping[str, Any]]:
    listed = manifest.get("sequences")
    found: dict[str, Mapping[str, Any]] = {}
    for entry in listed if isinstance(listed, list) else []:
        name = entry.get("folder") if isinstance(entry, dict) else None
        if isinstance(name, str) and is_sequence_name(name):
            found.setdefault(name, entry)
    return found


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


def _convention_faults(tree: Tree) -> Iterator[Fault]:
    """conventions.json: its words may be better in another version, its scales may not differ."""
    if CONVENTIONS not in tree.plain:
        return
    try:
        said = read_json(tree.root / CONVENTIONS)
    except BenchError as error:
        yield fault_of(error, tree.root)
        return
    known = conventions()
    for part, key in _SCALES:
        value = said.get(part)
        if not isinstance(value, dict) or value.get(key) != known[part][key]:
            yield Fault(CONVENTIONS, f"{part}.{key} is not {known[part][key]}")
