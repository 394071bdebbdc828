"""Scripts and performances: poses as functions of continuous time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Protocol

from sim.pose import Pose, Transform
from sim.specs import SceneSpec


class Script(Protocol):
    """A motion: pure, so that any frame rate and any order of frames gives the same poses."""

    def pose(self, t_s: float) -> Pose:
        """The pose at t_s >= 0 [s], already free of penetration."""
        ...

    def events(self, t_s: float) -> tuple[str, ...]:
        """Names of the events at t_s (for the truth's event labels)."""
        ...


@dataclass(frozen=True, eq=False)
class Performance:
    """A concrete sequence: scene, motion, frame times and the seed of its noise.

    learnt: places of objects while the background is learnt, where they differ from t = 0.
    redrawn: how many draws of this seed were thrown away because they could not be posed.
    """

    scene: SceneSpec
    script: Script
    frames: int
    fps: float
    background_frames: int
    seed: int
    learnt: Mapping[str, Transform] = field(default_factory=lambda: MappingProxyType({}))
    redrawn: int = 0
