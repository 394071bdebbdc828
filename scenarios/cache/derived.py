"""What is kept of footage beside its pictures: arrays, by everything that decides them."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path

from scenarios.cache.array_file import Arrays, arrays_from_bytes, arrays_to_bytes
from scenarios.cache.folder import CacheFolder, Kind, used_now
from scenarios.cache.settings import CacheSettings


class DerivedCache:
    """Entries of one kind in the cache of these settings; a key is plain values."""

    def __init__(self, settings: CacheSettings, kind: Kind) -> None:
        self._folder, self._kind = CacheFolder(settings), kind

    def read(self, key: Mapping[str, object]) -> Arrays | None:
        """The arrays of a key, used now; None where there are none. A damaged entry is removed."""
        path = self._path(key)
        try:
            record, arrays = arrays_from_bytes(path.read_bytes())
        except OSError:
            return None
        except ValueError:
            self.drop(key)
            return None
        if record != key:  # a file that was given another's name
            return None
        used_now(path)
        return arrays

    def drop(self, key: Mapping[str, object]) -> None:
        """Remove an entry: it is damaged."""
        with suppress(OSError):
            self._path(key).unlink()

    def write(self, key: Mapping[str, object], arrays: Arrays) -> None:
        """Keep the arrays of a key, in place of others; not where the disk refuses."""
        try:
            content = arrays_to_bytes(key, arrays)
        except ValueError:  # too large
            return
        with self._folder.pending(self._path(key)) as pending:
            if pending is not None:
                with suppress(OSError):
                    pending.file.write(content)
                    pending.keep = True

    def _path(self, key: Mapping[str, object]) -> Path:
        text = json.dumps(key, sort_keys=True, separators=(",", ":"))
        return self._folder.path(self._kind, hashlib.sha256(text.encode()).hexdigest())
