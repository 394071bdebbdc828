"""Verifies a copy of a data set from its files alone: every fault, named with its file.

No check knows how the labels were made. Each file is compared with the others: with the checksums,
the cameras with the calibration, the masks with the numbers of truth.parquet, the depth with the
truth's surfaces, the other view's depth, the disparity and the correspondence, the pictures with
the depth, the exports with the sequences.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pjpdaf.errors import FileError, InfrastructureError
from sim.dataset.check.exports.coco import FOLDER as COCO
from sim.dataset.check.exports.coco import check_coco
from sim.dataset.check.exports.mot import FOLDER as MOT
from sim.dataset.check.exports.mot import check_mot
from sim.dataset.check.exports.numbers import SequenceNumbers
from sim.dataset.check.fault import MISSING, Fault, FaultLog, fault_of
from sim.dataset.check.files import (
    Checksums,
    FileTree,
    check_digests,
    check_listing,
    read_checksums,
    tree_of,
)
from sim.dataset.check.sequence import SequenceVerdict, check_sequence
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
from sim.dataset.stored_sequence import StoredSequence
from sim.processes import Answer, Lost, WorkerPool

# Numbers of conventions.json without which a label cannot be read.
_SCALES = (("depth", "unit_m"), ("disparity", "scale"), ("correspondence", "scale"))

SEQUENCE_LIMIT_S = 24 * 3600.0


def verify(
    dataset_folder: Path | str,
    *,
    sums: bool = True,
    on_sequence: Callable[[str], None] = lambda name: None,
    jobs: int = 1,
) -> list[Fault]:
    """All faults of a data set, sorted by file; none where it is whole and consistent.

    sums: read all files to compare their SHA-256 as well; on_sequence is called with the name of
    each checked sequence; jobs: worker processes. Raises BenchError where the folder is not a data
    set or one of a newer version, InfrastructureError where the worker of a
    sequence dies three times.
    """
    root = Path(dataset_folder)
    contents = _contents(root)
    tree, names, log = contents.tree, contents.names, FaultLog(root)
    log.add("manifest", contents.faults)
    listed = read_checksums(tree, names, log)
    log.add("files", check_listing(tree, listed, names))
    if sums:
        top = [path for path in tree.plain if path.partition("/")[0] not in names]
        log.add("checksums", check_digests(tree, listed, top))
    numbers = {}
    for name, verdict in _verdicts(contents, listed, sums, jobs):
        log.faults += verdict.faults
        numbers[name] = verdict.numbers
        on_sequence(name)
    check_exports(tree, numbers, log)
    return sorted(set(log.all()))


@dataclass(frozen=True)
class _Contents:
    """The files of a data set and its sequences. entries: of the manifest, labels: by sequence."""

    tree: FileTree
    entries: Mapping[str, Mapping[str, Any]]
    labels: Mapping[str, tuple[str, ...]]
    faults: tuple[Fault, ...]

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(self.entries)


def _verdicts(
    contents: _Contents, checksums: Checksums, hash_files: bool, jobs: int
) -> Iterator[tuple[str, SequenceVerdict]]:
    """The sequences with their verdicts, in order, from worker processes where jobs is above 1."""
    plain: dict[str, set[str]] = {name: set() for name in contents.names}
    for path in contents.tree.plain:
        if (name := path.partition("/")[0]) in plain:
            plain[name].add(path)
    work = []
    for name in contents.names:
        digests = {path: checksums.digests[path] for path in plain[name] & set(checksums.digests)}
        work.append(
            (
                StoredSequence(contents.tree.root / name, contents.entries[name]),
                FileTree(contents.tree.root, frozenset(plain[name]), frozenset()),
                Checksums(digests),
                contents.labels[name],
                hash_files,
            )
        )
    if jobs <= 1 or len(work) <= 1:
        for name, task in zip(contents.names, work, strict=True):
            yield name, check_sequence(*task)
        return
    with WorkerPool(min(jobs, len(work))) as pool:
        outcomes = pool.outcomes(_check, dict(enumerate(work)), SEQUENCE_LIMIT_S)
        yield from _in_order(contents.names, outcomes)


def _in_order(
    names: Sequence[str], outcomes: Iterable[tuple[int, Answer[SequenceVerdict] | Lost] | None]
) -> Iterator[tuple[str, SequenceVerdict]]:
    """The verdicts in the order of the names, each as early as it can be given."""
    ended: dict[int, SequenceVerdict] = {}
    given = 0
    for indexed in outcomes:
        if indexed is None:
            continue
        index, outcome = indexed
        if isinstance(outcome, Lost):
            raise InfrastructureError(_lost_line(names[index], outcome))
        ended[index] = outcome.value
        while given in ended:
            yield names[given], ended.pop(given)
            given += 1


def _lost_line(name: str, lost: Lost) -> str:
    if lost.late:
        return f"{name}: not checked within {SEQUENCE_LIMIT_S / 3600:.0f} hours."
    return (
        f"{name}: its worker process died {lost.attempts} times (exit code {lost.exit_code}), "
        "likely for lack of memory: take fewer of them (--jobs)."
    )


def _check(
    work: tuple[StoredSequence, FileTree, Checksums, tuple[str, ...], bool],
) -> SequenceVerdict:
    return check_sequence(*work)


def _contents(root: Path) -> _Contents:
    """Read the manifest, as far as it is whole, and find the sequences' folders."""
    if not root.is_dir():
        raise FileError(root, "is not a data set: not a folder")
    tree = tree_of(root)
    there = sorted(
        {name for path in tree.plain if is_sequence_name(name := path.partition("/")[0])}
    )
    faults: list[Fault] = []
    manifest: Mapping[str, Any] = {}
    if MANIFEST in tree.plain:
        try:
            manifest = read_json(root / MANIFEST)
        except FileError as error:
            faults.append(fault_of(error, root))
    elif there:
        faults.append(Fault(MANIFEST, MISSING))
    if not there and manifest.get("kind") != KIND:
        raise FileError(root, f"is not a data set: has no {MANIFEST} and no sequences")
    if manifest:
        if manifest.get("kind") == KIND and manifest.get("schema") != SCHEMA_VERSION:
            version = manifest.get("schema")
            raise FileError(
                root / MANIFEST, f"is of version {version!r}, this is version {SCHEMA_VERSION}"
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
        with_files = (x for x in LABELS if any(tree.names(f"{name}/{sub}") for sub in LABELS[x]))
        labels[name] = tuple(
            [label for label in LABELS if label in named] if isinstance(named, list) else with_files
        )
    return _Contents(tree, {name: entries.get(name, {}) for name in there}, labels, tuple(faults))


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


def _convention_faults(tree: FileTree) -> Iterator[Fault]:
    """Check conventions.json: another version may explain more, but its scales may not differ."""
    if CONVENTIONS not in tree.plain:
        return
    try:
        stored = read_json(tree.root / CONVENTIONS)
    except FileError as error:
        yield fault_of(error, tree.root)
        return
    known = conventions()
    for part, key in _SCALES:
        value = stored.get(part)
        if not isinstance(value, dict) or value.get(key) != known[part][key]:
            yield Fault(CONVENTIONS, f"{part}.{key} is not {known[part][key]}")


def check_exports(
    tree: FileTree, sequences: Mapping[str, SequenceNumbers | None], log: FaultLog
) -> None:
    """Check the exports that are there. sequences: numbers by name, None is not compared."""
    folders = {path.partition("/")[0] for path in tree.plain if "/" in path}
    if COCO in folders:
        check_coco(tree, sequences, log)
    if MOT in folders:
        for numbers in filter(None, sequences.values()):
            log.add("mot", check_mot(tree, numbers))
