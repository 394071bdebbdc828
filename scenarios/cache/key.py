"""Keys of an episode's footage, still scene, detections and film: everything that decides them."""

from __future__ import annotations

import functools
import hashlib
import json
import platform
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from reports.run.provenance import package_versions
from scenarios.cache.sources import (
    detector_digest,
    film_digest,
    scene_digest,
    simulator_digest,
)
from scenarios.spec.names import load_scenario
from scenarios.spec.scenario import digest

# Where a processor has both, the software renderer's pixels are the same; elsewhere they are not.
EXTENSIONS = ("avx2", "fma")
CPU_INFO = Path("/proc/cpuinfo")
LIBRARIES = ("mujoco", "numpy", "opencv-python-headless", "scipy", "PyOpenGL")


@dataclass(frozen=True)
class FootageKey:
    """Plain values that decide the pictures; the renderer is the other part of an entry's name."""

    record: Mapping[str, object]

    @functools.cached_property
    def digest(self) -> str:
        """SHA-256 of the values, hexadecimal."""
        text = json.dumps(self.record, sort_keys=True, separators=(",", ":"))
        return hashlib.sha256(text.encode()).hexdigest()


def footage_key(episode_digest: str, twins: Sequence[str]) -> FootageKey:
    """The key of an episode by its digest, which has scenario, seed, changes, files and size.

    twins: names of the scenarios that can cause its draw to be thrown away.
    """
    return FootageKey(
        {
            "episode": episode_digest,
            "twins": {name: digest(load_scenario(name)) for name in twins},
            "simulator": simulator_digest(),
            "libraries": dict(library_versions()),
            "machine": machine(),
        }
    )


def detections_key(footage: FootageKey, renderer: str, recipe: str) -> Mapping[str, object]:
    """The key of the detections in footage that a renderer drew.

    recipe: of the detector, all of its parameters.
    """
    drawn = {"footage": footage.digest, "renderer": renderer}
    return {**drawn, "recipe": recipe, "detector": detector_digest()}


def scene_key(
    footage: FootageKey, renderer: str, smooth_noise: bool, align_views: bool
) -> Mapping[str, object]:
    """The key of what a detector sees in the person-free frames of footage (`still_scene`)."""
    drawn = {"footage": footage.digest, "renderer": renderer}
    parts = {"smooth_noise": smooth_noise, "align_views": align_views}
    return {**drawn, **parts, "scene": scene_digest()}


def film_key(footage: FootageKey, renderer: str) -> Mapping[str, object]:
    """The key of the small film of footage that a renderer drew."""
    return {"footage": footage.digest, "renderer": renderer, "film": film_digest()}


@functools.cache
def machine() -> str:
    """System, kind of processor, and those of its extensions on which pixels depend."""
    words = [platform.system(), platform.machine()]
    try:
        lines = CPU_INFO.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError):
        lines = []
    flags = next((line.split() for line in lines if line.startswith("flags")), [])
    return " ".join([*words, *(name for name in EXTENSIONS if name in flags)])


@functools.cache
def library_versions() -> Mapping[str, str]:
    """Versions of Python and of the libraries that compute poses and pictures."""
    return {"python": platform.python_version(), **package_versions(LIBRARIES)}
