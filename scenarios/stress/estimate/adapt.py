"""Adaptation of the proposal to the failures, by cross-entropy in rounds (Rubinstein 1999)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Floats
from scenarios.stress.estimate.fit import fitted
from scenarios.stress.estimate.outcomes import Outcomes, Play, noise_seeds, normal_draws
from scenarios.stress.estimate.proposal import NOMINAL_SHARE, Proposal

ELITE = 40  # draws that a proposal is fitted to, at least
ENOUGH = 80  # failures, after which the proposal is good enough
MOST_ROUNDS = 5


@dataclass(frozen=True, eq=False)
class Round:
    """Draws of a round: latents (n, d), their outcomes, and the proposal (None: nominal)."""

    latents: Floats
    outcomes: Outcomes
    proposal: Proposal | None

    @property
    def failed(self) -> NDArray[np.bool_]:
        """The failures among its draws (n,)."""
        return self.outcomes.failed & self.outcomes.counted


@dataclass(frozen=True, eq=False)
class Adaptation:
    """Result of an adaptation: proposal, None where no round had a failure; runs: draws spent."""

    proposal: Proposal | None
    runs: int


def pilot_round(play: Play, seed: int, n: int, d: int, stream: str = "") -> Round:
    """The first round: n draws of the nominal distribution of d latents."""
    stage = f"{stream}adapt0"
    latents = normal_draws(seed, stage, n, d)
    return Round(latents, play(latents, noise_seeds(seed, stage, n)), None)


def adapt(play: Play, seed: int, pilot: Round, stream: str = "") -> Adaptation:
    """Fit a proposal to the failures in at most `MOST_ROUNDS` rounds, each as large as the pilot.

    It is fitted to the failures of all rounds so far, or while these are fewer than `ELITE` to the
    draws that came nearest to failing, weighted as one sample of all rounds (Cornuet 2012).
    """
    n = len(pilot.latents)
    rounds = [pilot]
    while True:
        proposal = _fitted_to(rounds)
        failures = sum(int(r.failed.sum()) for r in rounds)
        if failures >= ENOUGH or len(rounds) == MOST_ROUNDS:
            return Adaptation(proposal if failures else None, n * len(rounds))
        stage = f"{stream}adapt{len(rounds)}"
        latents, _ = proposal.sample(seed, stage, n)
        rounds.append(Round(latents, play(latents, noise_seeds(seed, stage, n)), proposal))


def _fitted_to(rounds: Sequence[Round]) -> Proposal:
    latents = np.concatenate([r.latents for r in rounds])
    failed = np.concatenate([r.failed for r in rounds])
    objective = np.concatenate(
        [np.where(r.outcomes.counted, r.outcomes.objective, np.inf) for r in rounds]
    )
    if failed.sum() >= ELITE:
        elite = np.flatnonzero(failed)
    else:
        order = np.lexsort((np.arange(len(failed)), objective, ~failed))
        elite = np.sort(order[:ELITE])
    return fitted(latents[elite], _pooled_weights(latents[elite], rounds))


def _pooled_weights(latents: Floats, rounds: Sequence[Round]) -> Floats:
    """Nominal density / mean density of all rounds (balance heuristic), (n,)."""
    density = np.zeros(len(latents))
    for r in rounds:
        if r.proposal is None:
            density += 1.0 / len(rounds)
        else:
            adapted = np.exp(np.minimum(r.proposal.log_ratio(latents), 700.0))
            density += (NOMINAL_SHARE + (1.0 - NOMINAL_SHARE) * adapted) / len(rounds)
    return np.asarray(1.0 / density)
