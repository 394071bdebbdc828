"""The entries of the cache: recordings by key and renderer, the least recently used go first.

An entry appears whole, by renaming, and is checked when it is opened: processes need no lock, and
one that is killed leaves a part file, which a later one removes.
"""

from __future__ import annotations

import fcntl
import hashlib
import os
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

from pjpdaf.errors import FileError
from scenarios.cache.key import FootageKey
from scenarios.cache.renderer import MEMO
from scenarios.cache.settings import CacheSettings
from sim.files import disk_faults
from sim.recording.recording import Recording

ENTRIES, SUFFIX, PART_SUFFIX = "footage", ".rec", ".part"
YOUNG_S = 60.0  # a part file younger than this may not be locked yet


@dataclass(frozen=True)
class Entry:
    """A file of the cache. used_s: when it was last used, seconds since 1970."""

    path: Path
    bytes: int
    used_s: float


class PendingEntry:
    """An entry that is being written. keep: whether it becomes one at the end."""

    def __init__(self, file: BinaryIO) -> None:
        self.file, self.keep = file, False


class FootageCache:
    """The cache of these settings. A disk that refuses makes it useless, never harmful."""

    def __init__(self, settings: CacheSettings) -> None:
        self.settings = settings
        self._root = settings.folder / ENTRIES

    def find(self, key: FootageKey, renderer: str | None) -> Path | None:
        """The file of an entry, unopened; renderer None: of any renderer."""
        if renderer is not None:
            path = self._path(key, renderer)
            return path if path.is_file() else None
        folder = self._path(key, "").parent
        return min(folder.glob(f"{key.digest}-*{SUFFIX}"), default=None)

    def open(self, key: FootageKey, renderer: str | None) -> Recording | None:
        """The recording of a key, used now; None where there is none. A damaged one is removed."""
        path = self.find(key, renderer)
        if path is None:
            return None
        try:
            recording = Recording(path)
        except FileError:
            with suppress(OSError):
                path.unlink()
            return None
        except OSError:
            return None
        other = renderer is not None and recording.renderer != renderer
        if recording.footer.key != key.record or other:  # a file that was given another's name
            recording.close()
            return None
        with suppress(OSError):
            os.utime(path)
        return recording

    @contextmanager
    def pending(self, key: FootageKey, renderer: str) -> Iterator[PendingEntry | None]:
        """A new entry to be written; None where the disk refuses."""
        path = self._path(key, renderer)
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
        for path in self._root.glob(f"*/*{SUFFIX}"):
            with suppress(OSError):
                state = path.stat()
                found.append(Entry(path, state.st_size, state.st_mtime))
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
        for part in self._root.glob(f"*/*{PART_SUFFIX}"):
            _remove_abandoned(part)

    def clear(self) -> tuple[int, int]:
        """Remove all entries, abandoned part files, and what is remembered of the renderer.

        Returns the number and bytes of the entries. Raises BenchError where the disk refuses.
        """
        entries = self.entries()
        with disk_faults(self.settings.folder, "the cache"):
            for entry in entries:
                entry.path.unlink(missing_ok=True)
            (self.settings.folder / MEMO).unlink(missing_ok=True)
        for part in self._root.glob(f"*/*{PART_SUFFIX}"):
            _remove_abandoned(part)
        return len(entries), sum(entry.bytes for entry in entries)

    def _path(self, key: FootageKey, renderer: str) -> Path:
        mark = hashlib.sha256(renderer.encode()).hexdigest()[:16]
        return self._root / key.digest[:2] / f"{key.digest}-{mark}{SUFFIX}"


def _remove_abandoned(part: Path) -> None:
    """Remove a part file whose writer has ended: its lock is free."""
    with suppress(OSError):
        if time.time() - part.stat().st_mtime < YOUNG_S:
            return
        with part.open("rb") as file:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            part.unlink(missing_ok=True)
