"""Objects that move or change by themselves, without the person."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Protocol

from sim.pose import Pose, Transform
from sim.script import Script
from sim.specs import ObjectSpec


class Track(Protocol):
    """The place of an object over time, a pure function of t."""

    def at(self, t_s: float) -> Transform:
        """The place at t_s >= 0 [s]."""
        ...


@dataclass(frozen=True, eq=False)
class Extras:
    """objects: to add to the room; tracks: name -> how it moves (left out: it stands still);
    learnt: name -> where it is while the background is learnt, if elsewhere than at t = 0.
    """

    objects: tuple[ObjectSpec, ...] = ()
    tracks: Mapping[str, Track] = field(default_factory=lambda: MappingProxyType({}))
    learnt: Mapping[str, Transform] = field(default_factory=lambda: MappingProxyType({}))


NO_EXTRAS = Extras()


@dataclass(frozen=True, eq=False)
class WithExtras:
    """A `sim.script.Script` with objects that move by themselves added to its poses."""

    script: Script
    extras: Extras

    def pose(self, t_s: float) -> Pose:
        """The script's pose with the extras' places at t_s."""
        pose = self.script.pose(t_s)
        moved = {name: track.at(t_s) for name, track in self.extras.tracks.items()}
        return replace(pose, objects=MappingProxyType({**pose.objects, **moved}))

    def events(self, t_s: float) -> tuple[str, ...]:
        """The script's own."""
        return self.script.events(t_s)
