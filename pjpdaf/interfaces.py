"""Records that pass between detector and tracker, and the two plug-in protocols."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from numbers import Real
from typing import Any, Protocol, TypeVar, runtime_checkable

import numpy as np

from pjpdaf.arrays import Floats, readonly
from pjpdaf.frames import StereoFrame
from pjpdaf.looks import BlobLooks

STATUSES = ("waiting", "tracked", "coasting", "lost")


@dataclass(frozen=True, eq=False)
class Detections:
    """Blobs that the detector sees in one view.

    centres_px (n, 2) in the undistorted picture; covariances_px2 (n, 2, 2); ellipses (n, 5):
    centre x, y [px], semi-axes a >= b [px], angle of the major axis from +x towards +y [rad];
    areas_px (n,). missing: the picture itself was missing, so that absence means nothing.
    mask: optional uint8 (h, w) of the accepted skin pixels.
    evidence: optional (n, T), the log-likelihood of each blob's appearance if it shows target t,
    up to a constant for each blob; -inf rules the target out; None = no evidence.
    looks: optional, what else the picture shows of the blobs; not kept in saved runs.
    Raises ValueError for another shape, or for evidence that is NaN or +inf.
    """

    centres_px: Floats
    covariances_px2: Floats
    ellipses: Floats
    areas_px: Floats
    missing: bool = False
    mask: np.ndarray | None = field(default=None, repr=False)
    evidence: Floats | None = None
    looks: BlobLooks | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        n = len(self.centres_px)
        shapes: dict[str, tuple[int | None, ...]] = {
            "centres_px": (n, 2),
            "covariances_px2": (n, 2, 2),
            "ellipses": (n, 5),
            "areas_px": (n,),
        }
        if self.evidence is not None:
            shapes["evidence"] = (n, None)
        for name, shape in shapes.items():
            value = readonly(getattr(self, name), shape, f"Detections.{name}")
            object.__setattr__(self, name, value)
        if self.evidence is not None and not np.all(self.evidence < np.inf):  # false for NaN
            raise ValueError("Detections.evidence must be finite or -inf, got NaN or +inf")

    def __len__(self) -> int:
        return len(self.centres_px)

    @staticmethod
    def none(missing: bool = False) -> Detections:
        """Return an empty record."""
        return Detections(
            np.zeros((0, 2)), np.zeros((0, 2, 2)), np.zeros((0, 5)), np.zeros(0), missing
        )


@dataclass(frozen=True, eq=False)
class Estimates:
    """Estimates of the tracker after a frame; targets in the order of `pjpdaf.targets.TARGETS`.

    positions_m (T, 3) world; covariances_m2 (T, 3, 3); velocities_mps (T, 3);
    status (T,): of `STATUSES` ("waiting": not started yet, positions are NaN).
    exchange_probability: that the right and the left hand's rows are exchanged, 0-1, NaN where the
    tracker gives none.
    Raises ValueError for another shape, an unknown status, a probability outside 0-1.
    """

    positions_m: Floats
    covariances_m2: Floats
    velocities_mps: Floats
    status: tuple[str, ...]
    exchange_probability: float = math.nan

    def __post_init__(self) -> None:
        T = len(self.status)
        shapes = {"positions_m": (T, 3), "covariances_m2": (T, 3, 3), "velocities_mps": (T, 3)}
        for name, shape in shapes.items():
            value = readonly(getattr(self, name), shape, f"Estimates.{name}")
            object.__setattr__(self, name, value)
        unknown = set(self.status) - set(STATUSES)
        if unknown:
            raise ValueError(f"Estimates.status must be one of {STATUSES}, got {sorted(unknown)}")
        p = self.exchange_probability
        if not (isinstance(p, Real) and (math.isnan(p) or 0.0 <= p <= 1.0)):
            raise ValueError(
                f"Estimates.exchange_probability must be from 0 to 1, or NaN for none, got {p!r}"
            )
        object.__setattr__(self, "exchange_probability", float(p))

    @staticmethod
    def waiting(T: int = 3) -> Estimates:
        """Return the record of a tracker that has not started yet."""
        nan = np.nan
        return Estimates(
            np.full((T, 3), nan), np.full((T, 3, 3), nan), np.full((T, 3), nan), ("waiting",) * T
        )


class Detector(Protocol):
    """Pictures to measurements. Parameters and the background live on the object."""

    def learn(self, background: Iterable[StereoFrame]) -> Detector:
        """Return a detector that knows the person-free scene."""
        ...

    def __call__(
        self, frame: StereoFrame, predicted: Estimates | None = None
    ) -> tuple[Detections, ...]:
        """Return the detections of each view. predicted: where the tracker expects the targets."""
        ...


State = TypeVar("State")
PastState = TypeVar("PastState", contravariant=True)


class Tracker(Protocol[State]):
    """Measurements to 3-D. Parameters and cameras on the object; all that changes in State.

    Arguments are given by position; their names are free.
    """

    def start(self, detections: tuple[Detections, ...], /) -> State | None:
        """Return the first state, or None where this frame does not suffice to start: wait."""
        ...

    def step(
        self, state: State, detections: tuple[Detections, ...], dt_s: float, /
    ) -> tuple[State, Estimates]:
        """Return the state and the estimates after the next frame, dt_s later."""
        ...

    def estimates(self, state: State, /) -> Estimates:
        """Return the estimates of a state (used for the frame on which tracking started)."""
        ...

    def predict(self, state: State, dt_s: float, /) -> Estimates:
        """Return the estimates expected dt_s after `state`, handed to the detector."""
        ...


AnyTracker = Tracker[Any]


@runtime_checkable
class Smoother(Protocol[PastState]):
    """What a `Tracker` may add: fixed-lag smoothing, in which later frames tell of earlier ones."""

    def smoothed(self, states: tuple[PastState, ...], /) -> Estimates:
        """Return the estimates of the first of successive states, in the knowledge of the others.

        Of one state alone they are its `estimates`.
        """
        ...
