"""Recordings in the cache, by key and renderer."""

from __future__ import annotations

import hashlib
from contextlib import AbstractContextManager, suppress
from pathlib import Path

from pjpdaf.errors import FileError
from scenarios.cache.folder import CacheFolder, Kind, PendingEntry, used_now
from scenarios.cache.key import FootageKey
from scenarios.cache.settings import CacheSettings
from sim.recording.recording import Recording


class FootageCache:
    """The recordings in the cache of these settings; folder: with everything else in it."""

    def __init__(self, settings: CacheSettings) -> None:
        self.settings = settings
        self.folder = CacheFolder(settings)

    def find(self, key: FootageKey, renderer: str | None) -> Path | None:
        """The file of an entry, unopened; renderer None: of any renderer."""
        if renderer is not None:
            path = self._path(key, renderer)
            return path if path.is_file() else None
        folder = self._path(key, "").parent
        return min(folder.glob(f"{key.digest}-*{Kind.FOOTAGE.suffix}"), default=None)

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
        used_now(path)
        return recording

    def pending(
        self, key: FootageKey, renderer: str
    ) -> AbstractContextManager[PendingEntry | None]:
        """A new entry to be written; None where the disk refuses."""
        return self.folder.pending(self._path(key, renderer))

    def _path(self, key: FootageKey, renderer: str) -> Path:
        mark = hashlib.sha256(renderer.encode()).hexdigest()[:16]
        return self.folder.path(Kind.FOOTAGE, f"{key.digest}-{mark}")
