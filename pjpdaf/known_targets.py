"""Known positions in place of a stage's answer, to find the stage at fault for an error.

A tracker that lets its association or its prediction be replaced has one or both of the methods
below; it needs no base class. Who knows the positions is none of its business.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

import numpy as np

from pjpdaf.arrays import Floats, Ints, readonly
from pjpdaf.interfaces import Detections, Estimates


@dataclass(frozen=True, eq=False)
class KnownTargets:
    """Where the targets of a frame are.

    positions_m (T, 3) of their centres in the world; velocities_mps (T, 3); shown_by (N, T): number
    of the detection that shows each target in each view, -1 where none does, or one that shows
    several targets in one blob. Raises ValueError for another shape.
    """

    positions_m: Floats
    velocities_mps: Floats
    shown_by: Ints

    def __post_init__(self) -> None:
        T = len(self.positions_m)
        for name in ("positions_m", "velocities_mps"):
            value = readonly(getattr(self, name), (T, 3), f"KnownTargets.{name}")
            object.__setattr__(self, name, value)
        shown = readonly(self.shown_by, (None, T), "KnownTargets.shown_by", int)
        object.__setattr__(self, "shown_by", shown)

    def pixels(self, detections: tuple[Detections, ...]) -> Floats:
        """Centre of the detection that shows each target in each view (N, T, 2), NaN where none."""
        pixels = np.full((*self.shown_by.shape, 2), np.nan)
        for row, view, shown in zip(pixels, detections, self.shown_by, strict=True):
            row[shown >= 0] = view.centres_px[shown[shown >= 0]]
        return pixels


@runtime_checkable
class AssociationReplaceable(Protocol):
    """A tracker that can be told which measurement is whose."""

    def step_associated(
        self, state: Any, detections: tuple[Detections, ...], known: KnownTargets, dt_s: float, /
    ) -> tuple[Any, Estimates]:
        """Step as `step`, but give each target the measurement that is its own.

        known: of the frame of these detections.
        """
        ...


@runtime_checkable
class PredictionReplaceable(Protocol):
    """A tracker whose prediction can be set."""

    def expecting(self, state: Any, known: KnownTargets, dt_s: float, /) -> Any:
        """Return a state whose prediction dt_s later is at the known targets, else as `state`."""
        ...
