"""A probability of the fast fidelity, corrected by full runs of some of its draws.

Double sampling for stratification (Neyman 1938, Cochran 1977 chapter 12): many fast runs say how
often `fast` fails, P(fast); full runs of draws that it failed, and of draws that it passed, say how
often it is right, P(full | fast fails) and P(full | fast passes).

    P(full) = P(fast) P(full | fast fails) + (1 - P(fast)) P(full | fast passes)
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.special import ndtri

from pjpdaf.arrays import Floats
from scenarios.stress.estimate.probability import LEVEL, Probability
from sim.randomness import generator

MOST_UNTRIED = 0.2
_SAMPLES = 10_000


@dataclass(frozen=True)
class FullRuns:
    """Full runs of draws with the same fast outcome: how many, and how many failed."""

    runs: int
    failures: int


@dataclass(frozen=True)
class CorrectedProbability:
    """A probability of the full fidelity with its interval of `LEVEL`.

    fast: of the stand-in; failing, passing: the full runs of draws that it failed and passed;
    conclusive: the outcome of which no full run was played has a share of `MOST_UNTRIED` or less;
    the interval allows for all of it.
    """

    p: float
    low: float
    high: float
    fast: Probability
    failing: FullRuns
    passing: FullRuns
    conclusive: bool


def allocation(fast: Probability, full_runs: int) -> tuple[int, int]:
    """Full runs of draws that `fast` failed and that it passed, of `full_runs`.

    Neyman: in proportion to share times spread, with a guess of the spreads (it is right in 80 % of
    its failures and wrong in 2 % of its passes), at least a fifth to either.
    """
    failing = fast.p * 0.4
    passing = (1.0 - fast.p) * math.sqrt(0.02 * 0.98)
    share = min(max(failing / (failing + passing), 0.2), 0.8) if fast.failures else 0.0
    first = min(round(share * full_runs), fast.failures)
    return first, full_runs - first


def corrected(
    fast: Probability, failing: FullRuns, passing: FullRuns, seed: int = 0
) -> CorrectedProbability:
    """Combine the three shares.

    The interval is that of their joint posterior with Jeffreys' prior (Brown, Cai and DasGupta
    2001): unlike a variance it does not vanish where all full runs agree.
    """
    rng = generator(seed, "stress/correction")
    shares = _fast_samples(fast, rng)
    right, missed = (
        rng.beta(r.failures + 0.5, r.runs - r.failures + 0.5, _SAMPLES) for r in (failing, passing)
    )
    low, high = np.quantile(
        shares * right + (1.0 - shares) * missed, [(1 - LEVEL) / 2, (1 + LEVEL) / 2]
    )
    # Where no full run was played, p believes fast; the interval does not.
    p_failing = failing.failures / failing.runs if failing.runs else 1.0
    p_passing = passing.failures / passing.runs if passing.runs else 0.0
    p = fast.p * p_failing + (1.0 - fast.p) * p_passing
    untried = fast.p * (failing.runs == 0) + (1.0 - fast.p) * (passing.runs == 0)
    nothing = failing.failures == passing.failures == 0
    return CorrectedProbability(
        p=p,
        low=0.0 if nothing else float(low),
        high=float(high),
        fast=fast,
        failing=failing,
        passing=passing,
        conclusive=untried <= MOST_UNTRIED and fast.verdict != "inconclusive",
    )


def _fast_samples(fast: Probability, rng: np.random.Generator) -> Floats:
    """Samples of P(fast) from its posterior; of a weighted estimate, normal in the logarithm."""
    if fast.method == "plain" or fast.failures == 0:
        n = fast.runs
        return rng.beta(fast.failures + 0.5, n - fast.failures + 0.5, _SAMPLES)
    sd = math.log(fast.p / fast.low) / float(ndtri(0.5 + LEVEL / 2))
    return np.asarray(np.minimum(fast.p * np.exp(sd * rng.standard_normal(_SAMPLES)), 1.0))
