"""Generalised optimal sub-pattern assignment (GOSPA) of a frame or an episode.

Rahmathullah, García-Fernández, Svensson 2017, alpha = 2: localisation plus half the cut-off cost
for every missed and every false target.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pjpdaf.arrays import Floats
from reports.score.assignment import assignment
from reports.score.mot import distances, present

CUT_OFF_M = 0.15
ORDER = 2.0


@dataclass(frozen=True)
class Gospa:
    """Of one frame, each part in m^p: the metric is their sum to the power 1/p [m]."""

    localisation: float
    missed: float
    false: float
    order: float = ORDER

    @property
    def distance_m(self) -> float:
        """The metric."""
        return float((self.localisation + self.missed + self.false) ** (1.0 / self.order))


def gospa(
    truths_m: Floats, estimates_m: Floats, cut_off_m: float = CUT_OFF_M, order: float = ORDER
) -> tuple[Gospa, ...]:
    """GOSPA of each frame of truths (F, T, 3) and estimates (F, K, 3), NaN where there is none."""
    targets, tracks = present(truths_m), present(estimates_m)
    between = distances(truths_m, estimates_m)
    half = 0.5 * cut_off_m**order
    out = []
    for frame in range(len(truths_m)):
        # A pair at the cut-off costs as much as one missed and one false target.
        near = between[frame][np.ix_(targets[frame], tracks[frame])]
        cost = np.minimum(near, cut_off_m) ** order
        rows, columns = assignment(cost)
        paired = near[rows, columns] < cut_off_m
        pairs = int(paired.sum())
        out.append(
            Gospa(
                localisation=float(cost[rows, columns][paired].sum()),
                missed=half * (int(targets[frame].sum()) - pairs),
                false=half * (int(tracks[frame].sum()) - pairs),
                order=order,
            )
        )
    return tuple(out)
