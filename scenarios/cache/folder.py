"""The cache's folder: entries of every kind, the least recently used go first.

An entry appears whole, by renaming, and is checked when it is opened: processes need no lock, and
one that is killed leaves a part file, which a later one removes.
"""

from __future__ import annotations

import fcntl
import os
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import BinaryIO

from scenarios.cache.renderer import MEMO
from scenarios.cache.settings import CacheSettings
from sim.files import disk_faults

PART_SUFFIX = ".part"
YOUNG_S = 60.0  # a part file younger than this may not be locked yet


class Kind(StrEnum):
    """What an entry is, and the name of its folder."""

    FOOTAGE = "footage"
    DETECTIONS = "detections"
    FILMS = "films"
    SCENES = "scenes"

    @property
    def suffix(self) -> str:
        """The ending of its files."""
        return SUFFIXES[self]


SUFFIXES = {
    Kind.FOOTAGE: ".rec",
    Kind.DETECTIONS: ".det",
    Kind.FILMS: ".film",
    Kind.SCENES: ".scene",
}


@dataclass(frozen=True)
class Entry:
    """A file of the cache. used_s: when it was last used, seconds since 1970."""

    kind: Kind
    path: Path
    bytes: int
    used_s: float


class PendingEntry:
    """An entry that is being written. keep: whether it becomes one at the end."""

    def __init__(self, file: BinaryIO) -> None:
        self.file, self.keep = file, False


class CacheFolder:
    """The folder of these settings. A disk that refuses makes it useless, never harmful."""

    def __init__(self, settings: CacheSettings) -> None:
        self.settings = settings

    def path(self, kind: Kind, name: str) -> Path:
        """The path of an entry; name: begins with hexadecimal digits."""
        return self.settings.folder / kind / name[:2] / f"{name}{kind.suffix}"

    @contextmanager
    def pending(self, path: Path) -> Iterator[PendingEntry | None]:
        """A new entry to be written; None where the disk refuses."""
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            number, name = tempfile.mkstemp(PART_SUFFIX, f"{path.name}-", path.parent)
        except OSError:
            yield None
            return
        part, file = Path(name), os.fdopen(number, "wb")
        with suppress(OSError):
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        pending = PendingEntry(file)
        try:
            yield pending
        finally:
            # Not `with`: what the disk refuses now must not hide what the caller raised.
            with suppress(OSError):
                file.flush()
                if pending.keep:
                    part.replace(path)
                    self.trim()
            with suppress(OSError):
                part.unlink(missing_ok=True)
            with suppress(OSError):
                file.close()

    def entries(self) -> list[Entry]:
        """All entries, the least recently used first."""
        found = []
        for kind in Kind:
            for path in (self.settings.folder / kind).glob(f"*/*{kind.suffix}"):
                with suppress(OSError):
                    state = path.stat()
                    found.append(Entry(kind, path, state.st_size, state.st_mtime))
        return sorted(found, key=lambda entry: (entry.used_s, entry.path))

    def trim(self) -> None:
        """Remove the least recently used entries until the rest fits, and abandoned part files."""
        entries = self.entries()
        total = sum(entry.bytes for entry in entries)
        for entry in entries:
            if total <= self.settings.limit_bytes:
                break
            with suppress(OSError):
                entry.path.unlink(missing_ok=True)
                total -= entry.bytes
        self._remove_abandoned()

    def clear(self) -> list[Entry]:
        """Remove and return all entries; and abandoned part files, and the renderer's memo.

        Raises BenchError where the disk refuses.
        """
        entries = self.entries()
        with disk_faults(self.settings.folder, "the cache"):
            for entry in entries:
                entry.path.unlink(missing_ok=True)
            (self.settings.folder / MEMO).unlink(missing_ok=True)
        self._remove_abandoned()
        return entries

    def _remove_abandoned(self) -> None:
        for kind in Kind:
            for part in (self.settings.folder / kind).glob(f"*/*{PART_SUFFIX}"):
                _remove_if_abandoned(part)


def used_now(path: Path) -> None:
    """Note that an entry is used."""
    with suppress(OSError):
        os.utime(path)


def _remove_if_abandoned(part: Path) -> None:
    """Remove a part file whose writer has ended: its lock is free."""
    with suppress(OSError):
        if time.time() - part.stat().st_mtime < YOUNG_S:
            return
        with part.open("rb") as file:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            part.unlink(missing_ok=True)
