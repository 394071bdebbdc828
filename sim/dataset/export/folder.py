"""Folders that an export replaces whole, and the files of the data set that it takes over."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from pjpdaf.errors import FileError
from sim.dataset.files.layout import PART
from sim.dataset.reader import Dataset
from sim.dataset.stored_sequence import StoredSequence
from sim.files import disk_faults

_BEGINNINGS = {".png": b"\x89PNG\r\n\x1a\n", ".npz": b"PK"}


@contextmanager
def replaced_folder(folder: Path, what: str) -> Iterator[Path]:
    """A temporary folder beside `folder` to write into; at the end it takes its place.

    An exception inside removes it, and the older folder stays. A killed process leaves one that the
    next start removes. Raises BenchError of the disk, naming `what`.
    """
    folder = folder.absolute()
    part, old = (folder.with_name(f"{PART}{name}{folder.name}") for name in ("", "old-"))
    with disk_faults(folder, what):
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


def files_of(folder: Path) -> list[Path]:
    """All files below a folder, sorted."""
    return sorted(path for path in folder.rglob("*") if path.is_file())


def sequences_of(dataset: Dataset) -> Iterator[StoredSequence]:
    """The sequences one by one, each without the tables that it held: memory does not grow."""
    for sequence in dataset.sequences:
        yield StoredSequence(sequence.folder, sequence.entry)


def file_bytes(path: Path) -> bytes:
    """The bytes of a picture or NPZ file of a sequence, as they are.

    Raises BenchError where it is missing, of another kind, or a link: a data set of a stranger must
    not get other files of this machine into an export.
    """
    if path.is_symlink() or path.parent.is_symlink():
        raise FileError(path, "is a link; a data set holds plain files")
    try:
        data = path.read_bytes()
    except OSError as fault:
        raise FileError(path, f"cannot be read: {fault.strerror}") from fault
    if not data.startswith(_BEGINNINGS[path.suffix]):
        raise FileError(path, f"is not a {path.suffix[1:].upper()} file, or a damaged one")
    return data


def _remove(path: Path) -> None:
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)
