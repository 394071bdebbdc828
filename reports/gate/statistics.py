"""Paired comparison of two runs: clustered bootstrap, sign flips, exact McNemar, Holm.

The unit of all of them is the *draw*: the episodes that were made from the same random numbers
(twins, the rungs of a ladder, the same scenario in another light). They depend on each other, so
they are resampled together and have one vote.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr, stdtrit

from pjpdaf.arrays import Floats

RESAMPLES = 9999
LEVEL = 0.95


@dataclass(frozen=True)
class Difference:
    """A mean paired difference, new - base, with its two-sided interval.

    low, high: -inf, inf where one draw alone says nothing about the spread. n: episodes; draws:
    independent draws among them.
    """

    mean: float
    low: float
    high: float
    n: int
    draws: int


def clustered_bootstrap(
    differences: Floats,
    draws: Sequence[Hashable],
    strata: Sequence[str],
    rng: np.random.Generator,
    resamples: int = RESAMPLES,
    level: float = LEVEL,
) -> Difference:
    """The mean of per-episode differences (n,) with an interval.

    Whole draws (n,) are resampled within their stratum (n,), so that every resample has the
    suite's composition; a draw that spans strata is of their combination, and strata of one draw
    are pooled, as alone they would never vary. Few draws are allowed for twice: deviations are
    scaled by sqrt(m / (m - 1)) in a stratum of m draws (Rao and Wu 1988), and the percentiles are
    those of Student's t (Hesterberg 2015, expanded percentiles). Raises ValueError for none, or for
    numbers that are not finite.
    """
    n = len(differences)
    if not (n and len(draws) == len(strata) == n and np.isfinite(differences).all()):
        raise ValueError(f"need n > 0 finite differences with a draw and a stratum each, got {n}")
    mean = float(differences.mean())
    members = _members(draws)
    if not differences.any():
        return Difference(0.0, 0.0, 0.0, n, len(members))
    freedom = 0
    deviations = np.zeros(resamples)
    # The excess of each draw over its share of the mean; a draw weighs as its episodes.
    parts = np.array([(differences[m] - mean).sum() / n for m in members])
    for group in _strata(members, strata):
        m = len(group)
        if m == 1:
            continue
        freedom += m - 1
        chosen = parts[group] - parts[group].mean()
        drawn = rng.integers(0, m, size=(resamples, m))
        deviations += math.sqrt(m / (m - 1)) * chosen[drawn].sum(axis=1)
    if freedom == 0:
        return Difference(mean, -math.inf, math.inf, n, len(members))
    tail = float(ndtr(stdtrit(freedom, (1.0 - level) / 2)))
    low, high = np.quantile(deviations, [tail, 1.0 - tail])
    return Difference(mean, mean + float(low), mean + float(high), n, len(members))


def _members(draws: Sequence[Hashable]) -> list[NDArray[np.intp]]:
    """Positions of each draw's episodes, in order of first appearance."""
    members: dict[Hashable, list[int]] = {}
    for position, draw in enumerate(draws):
        members.setdefault(draw, []).append(position)
    return [np.array(positions, dtype=np.intp) for positions in members.values()]


def _strata(members: Sequence[NDArray[np.intp]], strata: Sequence[str]) -> list[NDArray[np.intp]]:
    """Group the draws that are resampled together; single draws of strata form a group."""
    by_strata: dict[tuple[str, ...], list[int]] = {}
    for index, positions in enumerate(members):
        by_strata.setdefault(tuple(sorted({strata[p] for p in positions.tolist()})), []).append(
            index
        )
    together = [group for group in by_strata.values() if len(group) > 1]
    alone = [index for group in by_strata.values() if len(group) == 1 for index in group]
    if len(alone) == 1 and together:  # a single draw would not vary: it joins the smallest
        min(together, key=len).extend(alone)
    elif alone:
        together.append(alone)
    return [np.array(group, dtype=np.intp) for group in together]


def totals(differences: Floats, draws: Sequence[Hashable]) -> Floats:
    """The sum of each draw's differences."""
    return np.array([differences[m].sum() for m in _members(draws)], dtype=np.float64)


def sign_flip(
    differences: Floats,
    draws: Sequence[Hashable],
    rng: np.random.Generator,
    resamples: int = RESAMPLES,
) -> float:
    """One-sided p-value that the new run is no worse, from the totals of the draws.

    If the two runs differed by chance alone, base and new of any draw could be exchanged (Fisher
    1935); how often is the sum then as large? All 2^m exchanges where these are no more than
    `resamples`, else random ones. Valid for any number of draws: of three none can be below 1/8.
    """
    # Draws without a difference are the same either way.
    changed = totals(differences, draws)
    changed = changed[changed != 0.0]
    m = len(changed)
    if m == 0:
        return 1.0
    observed = float(changed.sum()) - 1e-9 * float(np.abs(changed).sum())
    if 2**m <= resamples:
        signs = 1 - 2 * ((np.arange(2**m)[:, None] >> np.arange(m)) & 1)
        return float(np.mean(signs @ changed >= observed))
    signs = 1 - 2 * rng.integers(0, 2, size=(resamples, m), dtype=np.int8)
    return (1 + int((signs @ changed >= observed).sum())) / (1 + resamples)


def mcnemar(differences: Floats, draws: Sequence[Hashable]) -> float:
    """One-sided exact p-value that the new run has the event no more often (McNemar 1947).

    differences: +1 where only the new run has it, -1 where only the base. Only draws in which the
    two differ count, one vote each: of these, half should be the new one's. 1 where none differ.
    """
    from scipy.stats import binomtest  # takes half a second to load: every command would wait

    changed = totals(differences, draws)
    worse, better = int((changed > 0).sum()), int((changed < 0).sum())
    if worse + better == 0:
        return 1.0
    return float(binomtest(worse, worse + better, 0.5, alternative="greater").pvalue)


def holm(p_values: Sequence[float]) -> tuple[float, ...]:
    """Adjusted p-values (Holm 1979), in the order given, each at most 1."""
    order = np.argsort(p_values, kind="stable")
    adjusted = [0.0] * len(p_values)
    highest = 0.0
    for rank, index in enumerate(order.tolist()):
        highest = max(highest, min(1.0, (len(p_values) - rank) * p_values[index]))
        adjusted[index] = highest
    return tuple(adjusted)


def wilson(hits: int, n: int, level: float = LEVEL) -> tuple[float, float]:
    """Wilson's interval of a share (0, 1 where n = 0)."""
    from scipy.stats import binomtest

    if n == 0:
        return 0.0, 1.0
    interval = binomtest(hits, n).proportion_ci(level, method="wilson")
    return float(interval.low), float(interval.high)
