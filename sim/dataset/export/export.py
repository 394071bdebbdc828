"""An export of a data set: its folder is replaced whole; files of the data set are taken over.

Each sequence is written into a folder of its own, in any order and by any worker; these parts are
put together in the order of the data set, so that the bytes are the same for any number of workers.
"""

from __future__ import annotations

import shutil
from collections.abc import Callable, Collection, Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, replace
from importlib import import_module
from pathlib import Path

from pjpdaf.errors import BenchError, FileError
from sim.dataset.files.checksums import files_below
from sim.dataset.files.layout import EXPORTS_NEED, PART
from sim.dataset.reader import Dataset
from sim.dataset.sequence_tasks import sequence_results
from sim.dataset.stored_sequence import StoredSequence
from sim.files import disk_faults
from sim.processes import WorkerPool

WritePart = Callable[[StoredSequence, Collection[str], Path], None]
AddPart = Callable[[StoredSequence, Path], None]
PARTS = ".parts"  # folder of the parts, inside that of the unfinished export
_SIGNATURES = {".png": b"\x89PNG\r\n\x1a\n", ".npz": b"PK"}


@contextmanager
def moving(dataset: Dataset, folder: Path) -> Iterator[AddPart]:
    """Move the files and folders of the parts into `folder`: no two parts have one in common."""
    yield lambda sequence, part: move_content(part, folder)


@dataclass(frozen=True)
class Export:
    """A format of other tools.

    name: on the command line; folder: of its files, beside the sequences; title: of these files, in
    messages. write(sequence, labels, part): write a sequence into an empty folder, also in a
    worker; labels: of the data set. joining(dataset, folder): a context in which a function adds
    the parts, in the order of the data set, to the export's folder. library: that it needs, of the
    extra `dataset`.
    """

    name: str
    folder: str
    title: str
    write: WritePart
    joining: Callable[[Dataset, Path], AbstractContextManager[AddPart]] = moving
    library: str = ""

    def check_library(self) -> None:
        """Raise BenchError where the library is not installed."""
        if not self.library:
            return
        try:
            import_module(self.library)
        except ImportError as missing:
            package = self.library.partition(".")[0]
            raise BenchError(
                f"{self.title} need {package}, which is not installed: install "
                "pjpdaf-bench[dataset]."
            ) from missing

    def __call__(
        self,
        dataset: Dataset,
        into: Path,
        on_sequence: Callable[[str], None] = lambda name: None,
        pool: WorkerPool | None = None,
    ) -> list[Path]:
        """Write the folder into `into`, whole or not at all; an older folder is replaced.

        on_sequence is called with the name of each written sequence; pool: writes sequences in
        worker processes. Returns the files, sorted by path. Raises BenchError where the data set is
        damaged or lacks a label that the format needs, where a library is missing, and of the disk.
        """
        self.check_library()
        label = EXPORTS_NEED.get(self.name)
        if label is not None and label not in dataset.labels:
            raise FileError(dataset.folder, f"has no label {label}, of which {self.title} are made")
        folder = into.absolute() / self.folder
        with replaced_folder(folder, self.title) as unfinished:
            parts = unfinished / PARTS
            parts.mkdir()
            tasks = [
                _PartTask(self.write, s, dataset.labels, parts / s.name, folder, self.title)
                for s in dataset.sequences
            ]
            names = [sequence.name for sequence in dataset.sequences]
            faults = sequence_results(_write_part, tasks, names, pool, "exported")
            with self.joining(dataset, unfinished) as add:
                for task, fault in zip(tasks, faults, strict=True):
                    if fault is not None:
                        raise fault
                    add(task.sequence, task.part)
                    shutil.rmtree(task.part)
                    on_sequence(task.sequence.name)
            parts.rmdir()
        return files_below(folder)


@dataclass(frozen=True, eq=False)
class _PartTask:
    """A sequence that is to be written into the folder `part`. final, title: for messages."""

    write: WritePart
    sequence: StoredSequence
    labels: tuple[str, ...]
    part: Path
    final: Path
    title: str


def _write_part(task: _PartTask) -> BenchError | None:
    """Write a part; the fault of a data set or disk is returned, to be raised in its turn."""
    try:
        with disk_faults(task.final, task.title):
            _remove(task.part)  # what a killed worker left
            task.part.mkdir()
            # A copy keeps its tables to itself, and they go with it: memory does not grow.
            task.write(replace(task.sequence), task.labels, task.part)
    except BenchError as fault:
        return fault
    return None


def move_content(part: Path, folder: Path) -> None:
    """Move the files and folders in one folder into another on the same disk."""
    for path in sorted(part.iterdir()):
        path.rename(folder / path.name)


@contextmanager
def replaced_folder(folder: Path, title: str) -> Iterator[Path]:
    """A temporary folder beside `folder` to write into; at the end it takes its place.

    An exception inside removes it, and the older folder stays. The folder that a killed process
    leaves is removed at the next start. Raises BenchError of the disk, naming `title`.
    """
    folder = folder.absolute()
    part, old = (folder.with_name(f"{PART}{name}{folder.name}") for name in ("", "old-"))
    with disk_faults(folder, title):
        for left in (part, old):
            _remove(left)
        part.mkdir()
        try:
            yield part
            _put_in_place(part, folder, old)
        finally:
            _remove(part)


def _put_in_place(part: Path, folder: Path, old: Path) -> None:
    if folder.exists() or folder.is_symlink():
        folder.rename(old)
    try:
        part.rename(folder)
    except OSError:
        if old.exists():
            old.rename(folder)
        raise
    _remove(old)


def file_bytes(path: Path) -> bytes:
    """The bytes of a picture or NPZ file of a sequence, as they are.

    Raises FileError where it is missing, of another kind, or a link: a stranger's data set must not
    get other files of this machine into an export.
    """
    if path.is_symlink() or path.parent.is_symlink():
        raise FileError(path, "is a link; a data set holds plain files")
    try:
        data = path.read_bytes()
    except OSError as fault:
        raise FileError(path, f"cannot be read: {fault.strerror}") from fault
    if not data.startswith(_SIGNATURES[path.suffix]):
        raise FileError(path, f"is not a {path.suffix[1:].upper()} file, or a damaged one")
    return data


def _remove(path: Path) -> None:
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)
