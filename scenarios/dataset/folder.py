"""The folder of a data set while it is made: locks, leftovers, older content."""

from __future__ import annotations

import errno
import fcntl
import json
import os
import shutil
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import Any

from pjpdaf.errors import BenchError
from sim.dataset.files.layout import (
    MANIFEST,
    PART,
)
from sim.dataset.files.manifest import SequenceEntry
from sim.dataset.files.reading import read_json
from sim.dataset.reader import open_dataset
from sim.files import disk_faults


@contextmanager
def locked(folder: Path, wait: bool = True) -> Iterator[None]:
    """Hold the folder's lock; it ends with the process, however that ends.

    wait: for another process that holds it; else raises BlockingIOError. A file system without
    locks holds nothing. Raises OSError.
    """
    opened = os.open(folder, os.O_RDONLY)
    try:
        fcntl.flock(opened, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
    except OSError as fault:
        if fault.errno not in (errno.ENOLCK, errno.ENOTSUP, errno.ENOSYS, errno.EINVAL):
            os.close(opened)
            raise
    try:
        yield
    finally:
        os.close(opened)


@contextmanager
def only_process(out: Path) -> Iterator[None]:
    """Keep other processes from making this data set. Raises BenchError where another does."""
    with disk_faults(out, "the data set"), ExitStack() as held:
        try:
            held.enter_context(locked(out, wait=False))
        except BlockingIOError:
            raise BenchError(
                f"{out}: another process is making this data set; wait for it, or end it"
            ) from None
        opened = held.pop_all()
    with opened:
        yield


def remove_leftovers(out: Path) -> None:
    """Remove the half-written folders of killed processes, once these have really ended."""
    for path in (*out.glob(f"{PART}*"), *out.glob(".*.part-*")):
        with suppress(FileNotFoundError), locked(path):
            shutil.rmtree(path, ignore_errors=True)


def check_same_dataset(
    out: Path, settings: Mapping[str, Any], entries: Sequence[SequenceEntry]
) -> None:
    """Raise BenchError where the folder holds other files, or another data set."""
    path = out / MANIFEST
    if not path.exists():
        others = [p.name for p in out.iterdir() if not p.name.startswith(".")]
        if others:
            raise BenchError(
                f"{out}: is not empty ({sorted(others)[0]}) and not a data set; give a new folder"
            )
        return
    record = open_dataset(out).manifest
    had = record.get("settings")
    if had != json.loads(json.dumps(settings)):
        raise BenchError(f"{out}: holds a data set of other settings: {_difference(had, settings)}")
    before = [(e.get("folder"), e.get("digest")) for e in record["sequences"]]
    if before != [(entry.folder, entry.digest) for entry in entries]:
        raise BenchError(
            f"{out}: holds a data set of other scenarios or seeds ({len(before)} sequences, asked "
            f"for {len(entries)}); give another folder"
        )


def _difference(had: Any, asked: Mapping[str, Any]) -> str:
    before = had if isinstance(had, Mapping) else {}
    for key, value in asked.items():
        if before.get(key) != value:
            return f"{key} {before.get(key)}, asked for {value}; give another folder"
    return "give another folder"


def check_same_versions(out: Path, made_with: Mapping[str, Any]) -> None:
    """Raise BenchError where other versions than those of `made_with` began the data set."""
    path = out / MANIFEST
    if not path.exists():
        return
    before = read_json(path).get("made_with")
    if before != made_with:
        raise BenchError(
            f"{out}: was begun with another OpenGL library or other versions; the rest would not "
            "fit to it. Go on where it was begun, or give a new folder"
        )
