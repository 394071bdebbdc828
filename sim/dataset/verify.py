"""Verifies a copy of a data set from its files alone: every fault, named with its file.

No check knows how the labels were made. Each file is compared with the others: with the checksums,
the cameras with the calibration, the masks with the numbers of truth.parquet, the depth with the
truth's surfaces, the other view's depth, the disparity and the correspondence, the pictures with
the depth, the exports with the sequences.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import partial
from pathlib import Path

from sim.dataset.check.contents import DatasetContents, read_contents
from sim.dataset.check.exports.coco import FOLDER as COCO
from sim.dataset.check.exports.coco import check_coco
from sim.dataset.check.exports.hdf5 import FOLDER as HDF5
from sim.dataset.check.exports.hdf5 import check_hdf5
from sim.dataset.check.exports.mot import FOLDER as MOT
from sim.dataset.check.exports.mot import check_mot
from sim.dataset.check.exports.numbers import SequenceNumbers
from sim.dataset.check.fault import Fault, FaultLog
from sim.dataset.check.files import (
    Checksums,
    FileTree,
    check_digests,
    check_listing,
    read_checksums,
)
from sim.dataset.check.sequence import SequenceVerdict, check_sequence
from sim.dataset.check.splits import check_splits
from sim.dataset.files.reading import read_json
from sim.dataset.sequence_tasks import sequence_results
from sim.dataset.splits import SPLITS
from sim.dataset.stored_sequence import StoredSequence
from sim.processes import WorkerPool


def verify(
    dataset_folder: Path | str,
    *,
    sums: bool = True,
    on_sequence: Callable[[str], None] = lambda name: None,
    pool: WorkerPool | None = None,
) -> list[Fault]:
    """All faults of a data set, sorted by file; none where it is whole and consistent.

    sums: read all files to compare their SHA-256 as well; on_sequence is called with the name of
    each checked sequence; pool: checks sequences in worker processes. Raises FileError where the
    folder is not a data set or one of another version, InfrastructureError where the worker of a
    sequence dies three times.
    """
    root = Path(dataset_folder)
    log = FaultLog(root)
    contents = read_contents(root, log)
    tree, names = contents.tree, contents.names
    listed = read_checksums(tree, names, log)
    log.add("files", check_listing(tree, listed, names))
    if sums:
        top = [path for path in tree.plain if path.partition("/")[0] not in names]
        log.add("checksums", check_digests(tree, listed, top))
    numbers = {}
    for name, verdict in _verdicts(contents, listed, sums, pool):
        log.faults += verdict.faults
        numbers[name] = verdict.numbers
        on_sequence(name)
    check_exports(tree, numbers, log)
    if SPLITS in tree.plain:
        record = log.read(partial(read_json, root / SPLITS))
        sequences = [StoredSequence(root / name, contents.entries[name]) for name in contents.names]
        if record is not None:
            log.add("splits", check_splits(record, sequences))
    return sorted(set(log.all()))


def _verdicts(
    contents: DatasetContents, checksums: Checksums, hash_files: bool, pool: WorkerPool | None
) -> Iterator[tuple[str, SequenceVerdict]]:
    """The sequences with their verdicts, in order, from worker processes where there are."""
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
    verdicts = sequence_results(_check, work, contents.names, pool, "checked")
    yield from zip(contents.names, verdicts, strict=True)


def _check(
    work: tuple[StoredSequence, FileTree, Checksums, tuple[str, ...], bool],
) -> SequenceVerdict:
    return check_sequence(*work)


def check_exports(
    tree: FileTree, sequences: Mapping[str, SequenceNumbers | None], log: FaultLog
) -> None:
    """Check the exports that are there. sequences: numbers by name, None is not compared."""
    folders = {path.partition("/")[0] for path in tree.plain if "/" in path}
    if COCO in folders:
        check_coco(tree, sequences, log)
    checks = {MOT: check_mot, HDF5: check_hdf5}
    for folder in folders & set(checks):
        for numbers in filter(None, sequences.values()):
            log.add(folder, checks[folder](tree, numbers))
