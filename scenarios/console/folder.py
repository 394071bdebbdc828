"""The output folder of a verb: its usual name, and how it appears whole or not at all."""

from __future__ import annotations

import shutil
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from pjpdaf.errors import BenchError
from sim.files import disk_faults, part_folder

UNFINISHED = ".part"


@contextmanager
def written_whole(folder: Path) -> Iterator[Path]:
    """A temporary folder beside `folder` to write into; at the end it becomes `folder`.

    An exception inside removes it. Raises BenchError where `folder` is a file or not empty, or
    cannot be written, InfrastructureError where the disk is full.
    """
    folder = folder.absolute()
    with disk_faults(folder, "the results"):
        if folder.exists() and not folder.is_dir():
            raise BenchError(f"{folder}: is a file; give a new folder.")
        if folder.is_dir() and any(folder.iterdir()):
            raise BenchError(f"{folder}: exists and is not empty; give another folder.")
        folder.parent.mkdir(parents=True, exist_ok=True)
        part = part_folder(folder)
    try:
        yield part
        with disk_faults(folder, "the results"):
            part.chmod(0o755)
            part.rename(folder)  # onto an empty folder too
    finally:
        shutil.rmtree(part, ignore_errors=True)


def unfinished(folder: Path) -> Path:
    """The folder of results that are not finished, and will be `folder`."""
    return folder.with_name(folder.name + UNFINISHED)


def default_folder(targets: Sequence[str]) -> Path:
    """runs/NAME-DATE-TIME; a number follows where two runs start in the same second.

    Free is a name that no run has, finished or not.
    """
    name = "+".join(Path(target).stem for target in targets)[:60]
    base = Path("runs") / f"{name}-{time.strftime('%Y%m%d-%H%M%S')}"
    folder, number = base, 2
    while folder.exists() or unfinished(folder).exists():
        folder = base.with_name(f"{base.name}-{number}")
        number += 1
    return folder
