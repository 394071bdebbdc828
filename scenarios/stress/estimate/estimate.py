"""The probability of a failure within a number of runs: counted, or adapted, frozen and weighted.

Adaptation and estimate share no draw: the draws that chose the proposal (or that chose counting)
are spent. A proposal that concentrates on the failures it has seen would otherwise confirm itself,
and its spread would look small.
"""

from __future__ import annotations

from typing import Literal

from pjpdaf.errors import BenchError
from scenarios.stress.estimate.adapt import adapt, pilot_round
from scenarios.stress.estimate.outcomes import Play, noise_seeds, normal_draws
from scenarios.stress.estimate.probability import Probability, counted, weighted

METHODS = ("auto", "plain", "importance")
COUNTED_FAILURES = 30  # expected, from which on plain draws are as good and need no trust
LEAST_RUNS = 24
_PILOT_SHARE = 1 / 12


def estimate(
    play: Play,
    d: int,
    runs: int,
    seed: int,
    method: Literal["auto", "plain", "importance"] = "auto",
) -> Probability:
    """Estimate the probability of failure of latents of d dimensions, N(0, I).

    auto: a pilot of 1/12 of the runs decides: where the rest would have 30 failures or more, or
    where no failure turns up in the adaptation at all, the rest is plain. Raises BenchError for too
    few runs.
    """
    if runs < LEAST_RUNS:
        raise BenchError(f"an estimate needs at least {LEAST_RUNS} runs, got {runs}")
    if method == "plain":
        return _plain(play, d, runs, seed, 0)
    first = max(2, round(runs * _PILOT_SHARE))
    pilot = pilot_round(play, seed, first, d)
    failures = int(pilot.failed.sum())
    if method == "auto" and failures / first * (runs - first) >= COUNTED_FAILURES:
        return _plain(play, d, runs - first, seed, first)
    adapted = adapt(play, seed, pilot)
    left = runs - adapted.runs
    if adapted.proposal is None:
        return _plain(play, d, left, seed, adapted.runs)
    latents, nominal = adapted.proposal.sample(seed, "estimate", left)
    outcomes = play(latents, noise_seeds(seed, "estimate", left))
    weights = adapted.proposal.weights(latents, nominal / left)
    return weighted(weights, outcomes.failed, outcomes.counted, nominal, adapted.runs)


def _plain(play: Play, d: int, n: int, seed: int, spent: int) -> Probability:
    outcomes = play(normal_draws(seed, "estimate", n, d), noise_seeds(seed, "estimate", n))
    failed = int((outcomes.failed & outcomes.counted).sum())
    return counted(failed, int(outcomes.counted.sum()), spent)
