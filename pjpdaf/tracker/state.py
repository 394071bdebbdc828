"""State of the tracker, and the prediction from it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from pjpdaf.arrays import Floats, readonly


@dataclass(frozen=True, eq=False)
class TrackState:
    """All that changes from frame to frame.

    mean (T, 6): X Y Z [m], X' Y' Z' [m/s]; covariance (T, 6, 6); unseen_s (T,) time since the
    target was last located in two views [s]; status: as in `Estimates`.
    """

    mean: Floats
    covariance: Floats
    unseen_s: Floats
    status: tuple[str, ...]

    def __post_init__(self) -> None:
        T = len(self.status)
        shapes = {"mean": (T, 6), "covariance": (T, 6, 6), "unseen_s": (T,)}
        for name, shape in shapes.items():
            value = readonly(getattr(self, name), shape, f"TrackState.{name}")
            object.__setattr__(self, name, value)


class Prior(NamedTuple):
    """Predicted states with the measurement model of all views at that point.

    mean (T, 6); P (T, 6, 6); H (T, N, r, 6), zero where a target is behind the camera; R (r, r) of
    one view; z (N, T, 2) predicted pixels, NaN behind the camera.
    """

    mean: Floats
    P: Floats
    H: Floats
    R: Floats
    z: Floats
