"""The exact truth of a frame (numpy only; never reaches a detector or tracker)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Floats, readonly
from sim.event_names import is_merge


@dataclass(frozen=True, eq=False)
class ViewTruth:
    """The visible skin of the T targets in a view (order of `pjpdaf.targets.TARGETS`).

    centroids_px (T, 2): centroid of the visible skin, NaN where nothing is visible.
    visible_px, amodal_px (T,): pixels visible / with everything else removed, inside the picture.
    boxes_px (T, 4): x, y, width, height of the visible skin, 0-based, NaN where nothing is visible.
    merged (T, T) bool, symmetric, diagonal False: the visible skin of the two touches in this view,
    so that no detector of skin can see two blobs.
    """

    centroids_px: Floats
    visible_px: NDArray[np.int64]
    amodal_px: NDArray[np.int64]
    boxes_px: Floats
    merged: NDArray[np.bool_]

    def __post_init__(self) -> None:
        T = len(self.visible_px)
        fields: dict[str, tuple[tuple[int, ...], type]] = {
            "centroids_px": ((T, 2), np.float64),
            "visible_px": ((T,), np.int64),
            "amodal_px": ((T,), np.int64),
            "boxes_px": ((T, 4), np.float64),
            "merged": ((T, T), np.bool_),
        }
        for name, (shape, dtype) in fields.items():
            value = readonly(getattr(self, name), shape, f"ViewTruth.{name}", dtype)
            object.__setattr__(self, name, value)

    @property
    def visible_fractions(self) -> Floats:
        """visible / amodal pixels (T,), 0 where the target is out of the picture."""
        return np.asarray(self.visible_px / np.maximum(self.amodal_px, 1), dtype=np.float64)


@dataclass(frozen=True, eq=False)
class Truth:
    """The truth of a frame, world frame, of the moment time_s at which it was really taken.

    With shutter skew the right view is exposed later: its part of `views` is of that later moment,
    everything in three dimensions of time_s.

    centres_m (T, 3): centres of head and palms; velocities_mps (T, 3);
    surfaces_m (T, 3): centroid of the visible skin surface over all views, NaN where unseen.
    views: per camera. events: names of the events in this frame (contact, grasp, merge, ...).
    """

    index: int
    time_s: float
    centres_m: Floats
    velocities_mps: Floats
    surfaces_m: Floats
    views: tuple[ViewTruth, ...]
    events: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        T = len(self.centres_m)
        for name in ("centres_m", "velocities_mps", "surfaces_m"):
            object.__setattr__(self, name, readonly(getattr(self, name), (T, 3), f"Truth.{name}"))

    @property
    def script_events(self) -> tuple[str, ...]:
        """The events of the script, without the merges."""
        return tuple(name for name in self.events if not is_merge(name))
