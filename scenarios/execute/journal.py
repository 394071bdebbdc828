"""An append-only file of finished results, which survive Ctrl-C, a kill and a full disk."""

from __future__ import annotations

import fcntl
import hashlib
import os
import struct
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path

from pjpdaf.errors import BenchError
from sim.files import disk_faults, write_fault

FILE = "journal.bin"
_MAGIC = b"pjb1"
# Magic, length of the key, length of the payload, BLAKE2b of lengths, key and payload.
_HEAD = struct.Struct("<4sIQ16s")
_IDENTITY = "identity"
MAX_KEY = 4096


class Finished(Mapping[str, bytes]):
    """The results of a journal by key, in the order in which they were added, read on demand."""

    def __init__(self, file: int) -> None:
        self._file = file
        self._places: dict[str, tuple[int, int]] = {}

    def __getitem__(self, key: str) -> bytes:
        offset, length = self._places[key]
        return os.pread(self._file, length, offset)

    def __iter__(self) -> Iterator[str]:
        return iter(self._places)

    def __len__(self) -> int:
        return len(self._places)

    def _add(self, key: str, offset: int, length: int) -> None:
        self._places[key] = offset, length


class Journal:
    """The open journal of a folder. Nothing in it is ever unpickled or executed.

    finished: key -> payload. dropped: damaged records that were passed over when it was opened.
    """

    def __init__(self, path: Path, file: int) -> None:
        self._path, self._file = path, file
        self.finished = Finished(file)
        self.dropped = 0
        self._end = 0

    @staticmethod
    @contextmanager
    def open(folder: Path, identity: str) -> Iterator[Journal]:
        """The journal of a folder, which is made where it is missing; locked until the block ends.

        identity: of the work whose results it keeps; another work's journal is refused. Raises
        BenchError where another process has it, the folder holds something else, or cannot be
        written.
        """
        path = folder / FILE
        with disk_faults(path, "the journal"):
            if folder.exists() and not folder.is_dir():
                raise BenchError(f"{folder}: is a file; give a new folder.")
            if folder.is_dir() and not path.is_file() and any(folder.iterdir()):
                raise BenchError(f"{folder}: exists and is not empty; give another folder.")
            folder.mkdir(parents=True, exist_ok=True)
            file = os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o644)
        try:
            with disk_faults(path, "the journal"):
                _lock(file, fcntl.LOCK_EX, folder)
            journal = Journal(path, file)
            journal._read(identity)
            yield journal
        finally:
            os.close(file)

    @staticmethod
    @contextmanager
    def reading(folder: Path) -> Iterator[tuple[str | None, Finished]]:
        """Identity and results of a journal, which is not changed. Raises BenchError.

        The identity is None where its record is damaged.
        """
        path = folder / FILE
        try:
            file = os.open(path, os.O_RDONLY | os.O_CLOEXEC)
        except OSError as error:
            raise BenchError(f"{path}: cannot be read: {error.strerror or error}") from error
        try:
            with suppress(OSError):  # a disk without locks
                _lock(file, fcntl.LOCK_SH, folder)
            journal = Journal(path, file)
            _, owner = journal._index()
            yield owner, journal.finished
        finally:
            os.close(file)

    def append(self, key: str, payload: bytes) -> None:
        """Keep a result; it is on the disk when this returns.

        Raises BenchError where the disk refuses (InfrastructureError where it is full); then
        nothing of it is kept, and all that was kept before stays.
        """
        name = key.encode()
        if not 0 < len(name) <= MAX_KEY:
            raise ValueError(f"a key must have 1 to {MAX_KEY} bytes, got {len(name)}")
        record = _HEAD.pack(_MAGIC, len(name), len(payload), _checksum(name, payload))
        record += name + payload
        try:
            written = 0
            while written < len(record):
                written += os.pwrite(self._file, record[written:], self._end + written)
            os.fsync(self._file)
        except OSError as error:
            os.ftruncate(self._file, self._end)
            raise write_fault(self._path, "the journal", error) from error
        if key != _IDENTITY:
            self.finished._add(key, self._end + _HEAD.size + len(name), len(payload))
        self._end += len(record)

    def _read(self, identity: str) -> None:
        """Index all whole records; cut a torn one off the end."""
        kept, owner = self._index()
        if kept > 0 and owner != identity:
            raise BenchError(
                f"{self._path.parent}: holds results of other work, or of another version; give "
                "another folder, or remove it."
            )
        # Whatever lies behind the last whole record was being written when its writer was killed.
        os.ftruncate(self._file, kept)
        self._end = kept
        if owner is None:
            self.append(_IDENTITY, identity.encode())

    def _index(self) -> tuple[int, str | None]:
        """Index all whole records: where the last one ends, and whose work they are."""
        size = os.fstat(self._file).st_size
        offset, kept, owner = 0, 0, None
        while offset < size:
            record = self._record_at(offset, size)
            if record is None:
                self.dropped += 1
                offset = self._next_magic(offset + 1, size)
                continue
            key, start, length = record
            if key == _IDENTITY:
                owner = owner or os.pread(self._file, length, start).decode(errors="replace")
            else:
                self.finished._add(key, start, length)
            offset = kept = start + length
        return kept, owner

    def _record_at(self, offset: int, size: int) -> tuple[str, int, int] | None:
        """(key, offset and length of the payload) of a whole record; None where there is none."""
        head = os.pread(self._file, _HEAD.size, offset)
        if len(head) < _HEAD.size:
            return None
        magic, of_key, of_payload, checksum = _HEAD.unpack(head)
        start = offset + _HEAD.size
        if magic != _MAGIC or of_key > MAX_KEY or start + of_key + of_payload > size:
            return None
        name = os.pread(self._file, of_key, start)
        payload = os.pread(self._file, of_payload, start + of_key)
        if _checksum(name, payload) != checksum:
            return None
        return name.decode(errors="replace"), start + of_key, of_payload

    def _next_magic(self, offset: int, size: int) -> int:
        """Where the next record may begin; the end of the file without any."""
        step = 1 << 20
        while offset < size:
            block = os.pread(self._file, step + len(_MAGIC), offset)
            at = block.find(_MAGIC)
            if at >= 0:
                return offset + at
            offset += step
        return size


def _lock(file: int, kind: int, folder: Path) -> None:
    """Lock the open journal of a folder until it is closed.

    kind: LOCK_SH or LOCK_EX. Raises BenchError where another process has it, OSError on a disk
    without locks.
    """
    try:
        fcntl.flock(file, kind | fcntl.LOCK_NB)
    except BlockingIOError:
        raise BenchError(
            f"{folder}: another process is writing there; wait for it, or give another folder."
        ) from None


def _checksum(name: bytes, payload: bytes) -> bytes:
    lengths = struct.pack("<IQ", len(name), len(payload))
    whole = hashlib.blake2b(lengths, digest_size=16)
    whole.update(name)
    whole.update(payload)
    return whole.digest()
