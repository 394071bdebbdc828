"""Doubt of right and left: after both hands were hidden together, and of fast hands in one blob."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from pjpdaf.tracker.hypotheses.activity import share_of_motion
from pjpdaf.tracker.hypotheses.hypothesis import Hypothesis
from pjpdaf.tracker.hypotheses.memory import kept_share
from pjpdaf.tracker.hypotheses.parameters import HypothesisParameters, IdentityParameters

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
        return 0.5 + (before - 0.5) * kept_share(dt_s, p.hidden_memory_s)
    doubt = min(shifted(before, -side), 0.5)
    return doubt if doubt > LEAST else 0.0


def halves_doubt(hypotheses: Sequence[Hypothesis], dt_s: float, p: HypothesisParameters) -> float:
    """Probability, at most 1/2, that hands in one blob were named wrongly, beside the hypotheses'.

    Where the sleeves of such hands are wrong, or the blob is cut wrongly, nothing in the picture
    shows it. hypotheses: of a frame, from the likeliest, dt_s after the frame before; of hands that
    hardly move, motion knows the names.
    """
    if not all(hypotheses[0].halves):
        return 0.0
    speeds, costs = [h.speed_mps for h in hypotheses], [h.total for h in hypotheses]
    share = share_of_motion(speeds, costs, 1.0, dt_s, p.motion)
    return min(p.identity.halves_doubt * (1.0 - share), 0.5)


def shifted(probability: float, log_odds: float) -> float:
    """A probability below 1, its log-odds changed."""
    odds = probability / (1.0 - probability) * math.exp(log_odds)
    return odds / (1.0 + odds)


def either(one: float, other: float) -> float:
    """Probability that exactly one of two independent exchanges happened."""
    return one * (1.0 - other) + other * (1.0 - one)
