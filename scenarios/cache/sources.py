"""Digests of the code that decides an episode's pictures, and what is kept beside them."""

from __future__ import annotations

import functools
from collections.abc import Iterable, Iterator
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

# What takes part in the presets' detections beside the pictures, and in keeping them.
DETECTOR = (
    "pjpdaf/detector",
    "pjpdaf/arrays.py",
    "pjpdaf/camera.py",
    "pjpdaf/checks.py",
    "pjpdaf/errors.py",
    "pjpdaf/frames.py",
    "pjpdaf/interfaces.py",
    "pjpdaf/looks.py",
    "pjpdaf/printable.py",
    "pjpdaf/targets.py",
    "scenarios/cache/answers.py",
    "scenarios/cache/array_file.py",
    "scenarios/play/kept_detections.py",
    "scenarios/play/kept_scene.py",
)
# What takes part in a look at the person-free scene, and in keeping it: not the whole detector.
SCENE = (
    "pjpdaf/arrays.py",
    "pjpdaf/camera.py",
    "pjpdaf/detector/alignment.py",
    "pjpdaf/detector/exposure.py",
    "pjpdaf/detector/still_scene.py",
    "pjpdaf/frames.py",
    "scenarios/cache/array_file.py",
    "scenarios/play/kept_scene.py",
)
# What takes part in the small film of an episode, and in keeping it.
FILM = (
    "pjpdaf/arrays.py",
    "pjpdaf/camera.py",
    "pjpdaf/frames.py",
    "reports/pictures/encode.py",
    "reports/pictures/overlay.py",
    "reports/pictures/stills.py",
    "scenarios/cache/array_file.py",
    "scenarios/play/kept_film.py",
    "scenarios/play/pictures.py",
)


@functools.cache
def simulator_digest() -> str:
    """SHA-256 of the sources of the simulator that is running."""
    return sources_digest(package_root())


@functools.cache
def detector_digest() -> str:
    """SHA-256 of the sources of the presets' detectors."""
    return files_digest(package_root(), map(package_root().joinpath, files_of(DETECTOR)))


@functools.cache
def scene_digest() -> str:
    """SHA-256 of the sources that look at the person-free scene."""
    return files_digest(package_root(), map(package_root().joinpath, files_of(SCENE)))


@functools.cache
def film_digest() -> str:
    """SHA-256 of the sources that draw small films."""
    return files_digest(package_root(), map(package_root().joinpath, files_of(FILM)))


def package_root() -> Path:
    """The folder of the packages that are running."""
    return Path(str(sim.__file__)).parent.parent


def sources_digest(root: Path) -> str:
    """SHA-256 of paths and contents of the simulator's files below the folder of the packages."""
    return files_digest(root, (root / path for path in simulator_files(root)))


def simulator_files(root: Path) -> Iterator[str]:
    """Yield the simulator's files, relative to the folder of the packages."""
    for below in files_of((*SIMULATOR, *BUT_ALSO), root):
        apart = any(below.startswith(f"{folder}/") for folder in APART)
        if not apart or below in BUT_ALSO:
            yield below


def files_of(names: Iterable[str], root: Path | None = None) -> Iterator[str]:
    """Yield the files that are named or lie in named folders, but for compiled ones.

    root: the folder that names start from, None for that of the running packages.
    """
    root = root or package_root()
    for name in names:
        place = root / name
        for path in place.rglob("*") if place.is_dir() else (place,):
            if path.is_file() and "__pycache__" not in path.parts:
                yield path.relative_to(root).as_posix()
