"""What the tracker itself says of its errors over footage: standard deviations, right and left."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pjpdaf.interfaces import Estimates
from pjpdaf.targets import TARGETS

SURE_M = 0.05  # a position is sure where its stated standard deviation is at most this
DOUBTFUL = 0.1  # right and left are in doubt where an exchange is at least this likely
LARGEST_MM = 1000  # of the histogram; what is larger, or not stated, counts as this


@dataclass(frozen=True)
class StatedError:
    """Stated standard deviation of a target's position, root of the trace of its covariance.

    median_mm, p90_mm: quantiles over the frames, at most 1000; sure: share of the frames in which
    it is 50 mm or less. NaN without frames.
    """

    median_mm: float
    p90_mm: float
    sure: float


@dataclass(frozen=True)
class StatedDoubt:
    """Stated probability that right and left are exchanged.

    frames: those in which it is stated; mean: over these; doubtful: share of these in which it is
    10 % or more. NaN without frames.
    """

    frames: int
    mean: float
    doubtful: float


class StatedErrors:
    """Counts of the stated errors of all frames, of bounded size."""

    def __init__(self) -> None:
        self._counts = np.zeros((len(TARGETS), LARGEST_MM + 1), dtype=np.int64)
        self._stated = self._doubtful = 0
        self._probability = 0.0

    def add(self, estimates: Estimates) -> None:
        """Count a frame."""
        variances = np.einsum("tii->t", estimates.covariances_m2)
        sd_mm = 1000 * np.sqrt(np.maximum(variances, 0.0))
        place = np.ceil(np.minimum(np.nan_to_num(sd_mm, nan=LARGEST_MM), LARGEST_MM)).astype(int)
        self._counts[np.arange(len(TARGETS)), place] += 1
        stated = estimates.exchange_probability
        if not math.isnan(stated):
            self._stated += 1
            self._probability += stated
            self._doubtful += stated >= DOUBTFUL

    def error(self, target: int) -> StatedError:
        """The stated error of a target, in whole millimetres, rounded up."""
        counts = self._counts[target]
        frames = int(counts.sum())
        if not frames:
            return StatedError(math.nan, math.nan, math.nan)
        below = np.cumsum(counts)
        median, p90 = (float(np.searchsorted(below, q * frames)) for q in (0.5, 0.9))
        return StatedError(median, p90, float(below[round(1000 * SURE_M)]) / frames)

    def doubt(self) -> StatedDoubt:
        """The stated doubt of right and left."""
        n = self._stated
        if not n:
            return StatedDoubt(0, math.nan, math.nan)
        return StatedDoubt(n, self._probability / n, self._doubtful / n)
