"""An export of a data set: its folder is replaced whole; files of the data set are taken over."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

from pjpdaf.errors import FileError
from sim.dataset.files.checksums import files_below
from sim.dataset.files.layout import PART
from sim.dataset.reader import Dataset
from sim.dataset.stored_sequence import StoredSequence
from sim.files import disk_faults

AddSequence = Callable[[StoredSequence], None]
_SIGNATURES = {".png": b"\x89PNG\r\n\x1a\n", ".npz": b"PK"}


@dataclass(frozen=True)
class Export:
    """A format of other tools.

    folder: of its files, beside the sequences; title: of these files, in messages; writer: a
    context in which a function adds sequences to a new folder.
    """

    folder: str
    title: str
    writer: Callable[[Dataset, Path], AbstractContextManager[AddSequence]]

    def __call__(
        self,
        dataset: Dataset,
        into: Path,
        on_sequence: Callable[[str], None] = lambda name: None,
    ) -> list[Path]:
        """Write the folder into `into`, whole or not at all; an older folder is replaced.

        on_sequence is called with the name of each written sequence. Returns the files, sorted by
        path. Raises BenchError where the data set is damaged or lacks a label that the format
        needs, where a library is missing, and of the disk.
        """
        folder = into / self.folder
        with replaced_folder(folder, self.title) as part, self.writer(dataset, part) as add:
            for sequence in dataset.sequences:
                # A copy keeps its tables to itself, and they go with it: memory does not grow.
                add(replace(sequence))
                on_sequence(sequence.name)
        return files_below(folder)


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
