"""Histograms of a data set's labels, with the same bins for every data set."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Floats


@dataclass(frozen=True)
class Bins:
    """The quantity of a histogram and the edges of its bins, in `unit`.

    Each bin includes its lower edge, the last bin both edges; the first and the last bin include
    all values beyond them.
    """

    title: str
    unit: str
    edges: tuple[float, ...]


# The same for all data sets, so that two cards can be compared.
BINS: dict[str, Bins] = {
    "visible_fraction": Bins(
        "Visible share of a target's skin", "", tuple(np.linspace(0, 1, 11).round(2).tolist())
    ),
    "truncation": Bins(
        "Share of a target outside the picture", "", (0.0, 0.001, 0.1, 0.25, 0.5, 0.75, 0.999, 1.0)
    ),
    "distance": Bins(
        "Distance from the left camera", "m", tuple(np.linspace(0.4, 2.4, 11).round(2).tolist())
    ),
    # Edges of the classes dark, brown, tan, intermediate, light, very light.
    "skin_tone": Bins("Skin tone of the sequences, ITA", "deg", (-60, -30, 10, 28, 41, 55, 70)),
    "hand_speed": Bins(
        "Speed of the hands", "m/s", (0.0, 0.02, 0.05, 0.1, 0.2, 0.4, 0.8, 1.5, 3.0, 6.0)
    ),
    "motion": Bins(
        "Way from one frame to the next", "mm", (0, 2, 5, 10, 20, 50, 100, 200, 400, 800)
    ),
}


@dataclass(frozen=True)
class Histogram:
    """Numbers of values in each bin, by series such as "right_hand, left".

    missing: number of undefined values, such as visible shares of targets out of the picture.
    """

    bins: Bins
    counts: Mapping[str, tuple[int, ...]]
    missing: int

    @property
    def total(self) -> tuple[int, ...]:
        """Numbers of values in each bin, over all series."""
        bins = len(self.bins.edges) - 1
        return tuple(sum(counts[i] for counts in self.counts.values()) for i in range(bins))


def counted(values: Floats, edges: Sequence[float]) -> tuple[NDArray[np.int64], int]:
    """Numbers of values (n,) in the bins between edges, and the number of NaN or infinite."""
    finite = values[np.isfinite(values)]
    inside = np.clip(finite, edges[0], edges[-1])
    counts, _ = np.histogram(inside, np.array(edges, np.float64))
    return counts.astype(np.int64), len(values) - len(finite)


def shares(counts: Iterable[int]) -> list[float]:
    """Shares of the sum of the counts, 0 where that is 0."""
    numbers = list(counts)
    return [n / max(sum(numbers), 1) for n in numbers]
