"""The probability of a failure within a number of runs: counted, or adapted, frozen and weighted.

Adaptation and estimate share no draw: the draws that chose the proposal (or that chose counting)
are spent. A proposal that concentrates on the failures it has seen would otherwise confirm itself,
and its spread would look small.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Floats
from pjpdaf.errors import BenchError
from scenarios.stress.estimate.adapt import adapt, pilot_round
from scenarios.stress.estimate.outcomes import Bools, Outcomes, Play, noise_seeds, normal_draws
from scenarios.stress.estimate.probability import Probability, counted, weighted

MethodChoice = Literal["auto", "plain", "importance"]
METHODS: tuple[MethodChoice, ...] = get_args(MethodChoice)
COUNTED_FAILURES = 30  # expected, from which on plain draws are as good and need no trust
LEAST_RUNS = 24
_PILOT_SHARE = 1 / 12


@dataclass(frozen=True, eq=False)
class Sample:
    """The draws of an estimate, the first `nominal` of them from the nominal distribution.

    latents (n, d), seeds (n,) of the noise, weights (n,): nominal density / that drawn from.
    """

    latents: Floats
    seeds: NDArray[np.int64]
    outcomes: Outcomes
    weights: Floats
    nominal: int

    @property
    def failed(self) -> Bools:
        """Draws (n,) that failed."""
        return self.outcomes.failed & self.outcomes.counted

    @property
    def passed(self) -> Bools:
        """Nominal draws (n,) that did not fail."""
        first = np.arange(len(self.weights)) < self.nominal
        return first & ~self.outcomes.failed & self.outcomes.counted


def estimate(
    play: Play,
    d: int,
    runs: int,
    seed: int,
    method: MethodChoice = "auto",
    stream: str = "",
) -> tuple[Probability, Sample]:
    """Estimate the probability of failure of latents of d dimensions, N(0, I); and its draws.

    auto: a pilot of 1/12 of the runs decides: where the rest would have 30 failures or more, or
    where no failure turns up in the adaptation at all, the rest is plain. stream: whose random
    numbers. Raises BenchError for too few runs.
    """
    if runs < LEAST_RUNS:
        raise BenchError(f"an estimate needs at least {LEAST_RUNS} runs, got {runs}")
    if method == "plain":
        return _plain(play, d, runs, seed, 0, stream)
    first = max(2, round(runs * _PILOT_SHARE))
    pilot = pilot_round(play, seed, first, d, stream)
    failures = int(pilot.failed.sum())
    if method == "auto" and failures / first * (runs - first) >= COUNTED_FAILURES:
        return _plain(play, d, runs - first, seed, first, stream)
    adapted = adapt(play, seed, pilot, stream)
    left = runs - adapted.runs
    if adapted.proposal is None:
        return _plain(play, d, left, seed, adapted.runs, stream)
    stage = f"{stream}estimate"
    latents, nominal = adapted.proposal.sample(seed, stage, left)
    seeds = noise_seeds(seed, stage, left)
    outcomes = play(latents, seeds)
    weights = adapted.proposal.weights(latents, nominal / left)
    probability = weighted(weights, outcomes.failed, outcomes.counted, nominal, adapted.runs)
    return probability, Sample(latents, seeds, outcomes, weights, nominal)


def _plain(
    play: Play, d: int, n: int, seed: int, spent: int, stream: str
) -> tuple[Probability, Sample]:
    stage = f"{stream}estimate"
    latents, seeds = normal_draws(seed, stage, n, d), noise_seeds(seed, stage, n)
    sample = Sample(latents, seeds, play(latents, seeds), np.ones(n), n)
    played = int(sample.outcomes.counted.sum())
    return counted(int(sample.failed.sum()), played, spent), sample
