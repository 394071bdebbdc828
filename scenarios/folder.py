"""An output folder that appears whole or not at all."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from pjpdaf.errors import BenchError


@contextmanager
def written_whole(folder: Path) -> Iterator[Path]:
    """A temporary folder beside `folder` to write into; at the end it becomes `folder`.

    An exception inside removes it. Raises BenchError where `folder` is a file or not empty, or
    cannot be written.
    """
    folder = folder.absolute()
    try:
        if folder.exists() and not folder.is_dir():
            raise BenchError(f"{folder}: is a file; give a new folder.")
        if folder.is_dir() and any(folder.iterdir()):
            raise BenchError(f"{folder}: exists and is not empty; give another folder.")
        folder.parent.mkdir(parents=True, exist_ok=True)
        part = Path(tempfile.mkdtemp(prefix=f".{folder.name}.part-", dir=folder.parent))
    except OSError as error:
        raise BenchError(f"{folder}: cannot be written: {error.strerror or error}.") from error
    try:
        yield part
        part.chmod(0o755)
        try:
            part.rename(folder)  # onto an empty folder too
        except OSError as error:
            raise BenchError(f"{folder}: cannot be written: {error.strerror or error}.") from error
    finally:
        shutil.rmtree(part, ignore_errors=True)
