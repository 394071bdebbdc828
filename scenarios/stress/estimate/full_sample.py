"""Which draws of a fast estimate are played in full, to correct it."""

from __future__ import annotations

import numpy as np

from scenarios.stress.estimate.estimate import Sample
from sim.randomness import generator


def failing_draws(sample: Sample, n: int, seed: int) -> list[int]:
    """Positions of n failures, drawn in proportion to their weights: those of the distribution.

    Of equal weights each at most once; a heavy one may come twice.
    """
    failed = np.flatnonzero(sample.failed)
    if not len(failed) or n <= 0:
        return []
    rng = generator(seed, "stress/full/failing")
    failed = rng.permutation(failed)
    total = np.cumsum(sample.weights[failed])
    # Systematic: one random start, then equal steps.
    places = (np.arange(n) + rng.random()) / n * total[-1]
    chosen = failed[np.searchsorted(total, places, side="right")]
    return sorted(int(n) for n in chosen)


def passing_draws(sample: Sample, n: int) -> list[int]:
    """Positions of the first n nominal draws that fast passed; they are in random order."""
    return [int(i) for i in np.flatnonzero(sample.passed)[: max(n, 0)]]
