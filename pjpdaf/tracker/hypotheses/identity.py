"""Doubt of right and left: as the hypotheses have it, and after both hands were hidden together."""

from __future__ import annotations

import math

import numpy as np

from pjpdaf.tracker.hypotheses.hypothesis import Hypothesis
from pjpdaf.tracker.hypotheses.parameters import IdentityParameters

LEAST = 1e-3  # less doubt than this is none


def hidden_doubt(
    before: float, hands: Hypothesis, side: float, dt_s: float, p: IdentityParameters
) -> float:
    """Probability, at most 1/2, that the hands changed places while both were hidden.

    before: a frame earlier, dt_s ago; hands: the likeliest hypothesis; side: log-odds that its
    right and left are the right way round, from the sleeves of this frame. While both hands are
    unseen for long enough to have met, doubt grows towards 1/2; seen again, evidence takes it away.
    """
    if p.hidden_memory_s <= 0:
        return 0.0
    unseen_s = float(hands.unseen_s.min())
    if unseen_s > 0:
        apart_m = float(np.linalg.norm(hands.means[0] - hands.means[1]))
        if unseen_s * p.hidden_speed_mps < apart_m:
            return before
        return 0.5 + (before - 0.5) * math.exp(-dt_s / p.hidden_memory_s)
    doubt = min(shifted(before, -side), 0.5)
    return doubt if doubt > LEAST else 0.0


def shifted(probability: float, log_odds: float) -> float:
    """A probability below 1, its log-odds changed."""
    odds = probability / (1.0 - probability) * math.exp(log_odds)
    return odds / (1.0 + odds)


def either(one: float, other: float) -> float:
    """Probability that exactly one of two independent exchanges happened."""
    return one * (1.0 - other) + other * (1.0 - one)
