"""Encodes files in threads beside the renderer, and keeps their checksums."""

from __future__ import annotations

import hashlib
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path

THREADS = 2  # encode beside the renderer
WAITING = 24  # files that wait to be encoded; bounds the memory


class FileEncoder:
    """Writes files below a folder. sums: SHA-256 by path, complete after `finish`.

    A fault of the disk is raised where a later file is added, or by `finish`.
    """

    def __init__(self, folder: Path, pool: Executor) -> None:
        self._folder, self._pool = folder, pool
        self._waiting: deque[Future[tuple[str, str]]] = deque()
        self._folders: set[Path] = set()
        self.sums: dict[str, str] = {}

    def add(self, path: str, encode: Callable[[], bytes]) -> None:
        """Write the result of `encode`, called in another thread, to a path below the folder."""
        while len(self._waiting) >= WAITING:
            self._take()
        file = self._folder / path
        if file.parent not in self._folders:
            file.parent.mkdir(parents=True, exist_ok=True)
            self._folders.add(file.parent)
        self._waiting.append(self._pool.submit(_write, file, path, encode))

    def finish(self) -> None:
        """Wait for all files."""
        while self._waiting:
            self._take()

    def _take(self) -> None:
        path, digest = self._waiting.popleft().result()
        self.sums[path] = digest


@contextmanager
def encoding_into(folder: Path) -> Iterator[FileEncoder]:
    """An encoder that has written all its files at the end. Raises OSError of the disk."""
    pool = ThreadPoolExecutor(THREADS)
    try:
        encoder = FileEncoder(folder, pool)
        yield encoder
        encoder.finish()
    finally:
        pool.shutdown(cancel_futures=True)


def _write(file: Path, path: str, encode: Callable[[], bytes]) -> tuple[str, str]:
    data = encode()
    file.write_bytes(data)
    return path, hashlib.sha256(data).hexdigest()
