"""A probability with its interval, and the two ways to it: counting, and weighted draws."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.special import ndtri

from pjpdaf.arrays import Floats
from scenarios.stress.estimate.outcomes import Bools

LEVEL = 0.95
LEAST_ESS = 100.0
MOST_WEIGHT = 0.05
Method = Literal["plain", "importance"]
Verdict = Literal["estimated", "bound", "inconclusive"]


@dataclass(frozen=True)
class Probability:
    """A probability of failure.

    low, high: its interval of `LEVEL`; where nothing failed, low = p = 0 and high is the bound.
    runs, adaptation_runs: draws behind the estimate, and those spent before it; ess: effective
    number of failures, (sum w)² / sum w²; largest_weight: the largest share of a draw in p.
    """

    p: float
    low: float
    high: float
    method: Method
    verdict: Verdict
    runs: int
    failures: int
    ess: float
    largest_weight: float
    adaptation_runs: int = 0


def clopper_pearson(hits: int, n: int, level: float = LEVEL) -> tuple[float, float]:
    """The exact interval of a share (Clopper and Pearson 1934); 0, 1 where n = 0.

    Where nothing or everything hits, the other end is one-sided: about 3 / n of 1 or 0.
    """
    from scipy.stats import binomtest  # takes half a second to load: every command would wait

    if n == 0:
        return 0.0, 1.0
    if hits in (0, n):
        level = 2 * level - 1
    interval = binomtest(hits, n).proportion_ci(level, method="exact")
    return float(interval.low), float(interval.high)


def counted(failures: int, n: int, adaptation_runs: int = 0) -> Probability:
    """The probability of plain draws: `failures` of n."""
    low, high = clopper_pearson(failures, n)
    return Probability(
        p=failures / n if n else 0.0,
        low=low,
        high=high,
        method="plain",
        verdict="estimated" if failures else "bound",
        runs=n,
        failures=failures,
        ess=float(failures),
        largest_weight=1.0 / failures if failures else 1.0,
        adaptation_runs=adaptation_runs,
    )


def weighted(
    weights: Floats, failed: Bools, counts: Bools, nominal: int, adaptation_runs: int
) -> Probability:
    """The probability of importance-weighted draws (n,), the first `nominal` of them nominal.

    counts: False for draws that are none; the weights of the others make up the whole. The interval
    is normal in log p: weighted sums of rare failures are skewed. Inconclusive where the effective
    number of failures or the largest weight is bad: then a region may be missing, and the interval
    would not know. Without a failure only the nominal draws bound p.
    """
    n = len(weights)
    drawn = weights * (failed & counts)
    total = float(drawn.sum())
    if total == 0.0:
        high = clopper_pearson(0, int(counts[:nominal].sum()))[1]
        return Probability(
            0.0, 0.0, high, "importance", "inconclusive", n, 0, 0.0, 1.0, adaptation_runs
        )
    # Unposable draws leave the whole, so the share of the others is estimated as well.
    whole = 1.0 if counts.all() else float(np.mean(weights * counts))
    p = min(total / n / whole, 1.0)
    residual = drawn / whole - (0.0 if counts.all() else p * weights * counts / whole)
    strata = [residual[:nominal], residual[nominal:]]
    variance = sum(len(part) * float(part.var(ddof=1)) for part in strata if len(part) > 1) / n**2
    factor = math.exp(float(ndtri(0.5 + LEVEL / 2)) * math.sqrt(variance) / p)
    ess = total**2 / float(np.sum(drawn**2))
    largest = float(drawn.max()) / total
    good = ess >= LEAST_ESS and largest <= MOST_WEIGHT
    return Probability(
        p=p,
        low=p / factor,
        high=min(p * factor, 1.0),
        method="importance",
        verdict="estimated" if good else "inconclusive",
        runs=n,
        failures=int((failed & counts).sum()),
        ess=ess,
        largest_weight=largest,
        adaptation_runs=adaptation_runs,
    )
