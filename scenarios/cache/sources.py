"""The digest of all code that decides the pictures of an episode."""

from __future__ import annotations

import functools
from collections.abc import Iterator
from pathlib import Path

import sim
from sim.files import files_digest

# Folders and files, from the folder of the packages, that take part in drawing values, posing,
# rendering, sensing and recording. A test compares them with what these import.
SIMULATOR = (
    "sim",
    "scenarios/spec",
    "scenarios/play/job.py",
    "scenarios/play/footage.py",
    "scenarios/play/recipe.py",
    "pjpdaf/arrays.py",
    "pjpdaf/camera.py",
    "pjpdaf/errors.py",
    "pjpdaf/frames.py",
    "pjpdaf/plugins/loading.py",
    "pjpdaf/printable.py",
    "pjpdaf/targets.py",
)
# Below `SIMULATOR`, but above what draws, but for the files that it does import.
APART = ("sim/dataset", "sim/silhouettes")
BUT_ALSO = (
    "sim/dataset/files/cameras.py",
    "sim/silhouettes/arms_over.py",
    "sim/silhouettes/contact_over.py",
    "sim/silhouettes/planned_arms.py",
    "sim/silhouettes/possible.py",
)


@functools.cache
def simulator_digest() -> str:
    """SHA-256 of the sources of the simulator that is running."""
    return sources_digest(Path(str(sim.__file__)).parent.parent)


def sources_digest(root: Path) -> str:
    """SHA-256 of paths and contents of the simulator's files below the folder of the packages."""
    return files_digest(root, (root / path for path in simulator_files(root)))


def simulator_files(root: Path) -> Iterator[str]:
    """Yield the simulator's files, relative to the folder of the packages."""
    for name in (*SIMULATOR, *BUT_ALSO):
        place = root / name
        for path in place.rglob("*") if place.is_dir() else (place,):
            below = path.relative_to(root).as_posix()
            compiled = "__pycache__" in path.parts
            apart = any(below.startswith(f"{folder}/") for folder in APART)
            if path.is_file() and not compiled and (not apart or below in BUT_ALSO):
                yield below
