"""Occlusion rules (thesis 3.3.2): which targets share a merged blob in a view."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol, final

import numpy as np

from pjpdaf.arrays import Bools, Floats
from pjpdaf.tracker.jpda import clusters


class OcclusionRule(Protocol):
    """Decides in which views R is infinity for a target (Eq. 3.23)."""

    def __call__(self, gated: Bools, beta: Floats) -> Bools:
        """Merged targets (T,) of a view from its gates (m, T) and association weights (m, T)."""
        ...


@final
@dataclass(frozen=True)
class SharedMeasurement:
    """Rule as printed: a measurement lies in the gates of two targets."""

    def __call__(self, gated: Bools, beta: Floats) -> Bools:
        """Return the targets with such a measurement in their gate, (T,)."""
        return np.asarray(gated[gated.sum(axis=1) > 1].any(axis=0))


@final
@dataclass(frozen=True)
class FewerMeasurements:
    """Rule: a cluster of gates holds fewer measurements than targets, certain pairs apart.

    certain: a measurement that a target holds with this weight is no merged blob; else a lost
    target, whose gate covers everything, would keep all others from their measurements.
    """

    certain: float = 0.9

    def __call__(self, gated: Bools, beta: Floats) -> Bools:
        """Return the targets of such clusters, (T,)."""
        merged = np.zeros(gated.shape[1], dtype=bool)
        if gated.sum(axis=1).max() > 1:
            certain = beta >= self.certain
            doubtful = gated & ~certain.any(axis=0) & ~certain.any(axis=1, keepdims=True)
            for targets, measurements in clusters(doubtful):
                merged[targets] = 0 < len(measurements) < len(targets)
        return merged


@final
@dataclass(frozen=True)
class NoOcclusion:
    """Rule that leaves no view out."""

    def __call__(self, gated: Bools, beta: Floats) -> Bools:
        """Return all false, (T,)."""
        return np.zeros(gated.shape[1], dtype=bool)


OCCLUSION_RULES: Mapping[str, OcclusionRule] = {
    "shared_measurement": SharedMeasurement(),
    "fewer_measurements": FewerMeasurements(),
    "none": NoOcclusion(),
}
