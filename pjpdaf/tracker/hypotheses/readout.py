"""Readout: estimates and exchange probability from hypotheses."""

from __future__ import annotations

import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.interfaces import Estimates
from pjpdaf.tracker.hypotheses.geometry import Views
from pjpdaf.tracker.hypotheses.head import HeadTrack
from pjpdaf.tracker.hypotheses.hypothesis import Hypothesis
from pjpdaf.tracker.hypotheses.identity import either, shifted
from pjpdaf.tracker.hypotheses.parameters import HypothesisParameters


def read_out(
    head: HeadTrack,
    hypotheses: tuple[Hypothesis, ...],
    before: Estimates | None,
    views: Views,
    dt_s: float,
    p: HypothesisParameters,
    doubt: float = 0.0,
) -> Estimates:
    """The mean of the hypotheses near the best, with their spread; status of the best.

    The exchange probability is the calibrated weight of the exchanged hypotheses, or else of an
    exchange while the hands were hidden, whose probability is doubt.
    """
    totals = np.array([h.total for h in hypotheses])
    best = hypotheses[int(totals.argmin())]
    share = np.exp(totals.min() - totals) * (totals <= totals.min() + p.mean_within)
    share /= share.sum()
    means = np.array([h.means for h in hypotheses])
    hands = np.einsum("k,kij->ij", share, means)
    off = means - hands
    P: Floats = np.einsum("k,kisj->isj", share, np.array([h.covariances for h in hypotheses]))
    P = P + np.einsum("k,kis,kij->isj", share, off, off)
    offset = np.array(p.offsets.hand_offset_m) @ views.axes
    positions = np.concatenate([head.centre(views.axes, p)[None], hands + offset])
    # The offset between surface and centre differs from person to person and from pose to pose.
    head_P = head.covariance + np.eye(3) * p.offsets.head_offset_sd_m**2
    # Successive frames of one merge repeat the error of its cut.
    own = p.offsets.hand_offset_sd_m**2
    offset_m2 = own + np.array(best.halves) * p.offsets.halves_sd_m**2
    covariances = np.concatenate([head_P[None], P + offset_m2[:, None, None] * np.eye(3)])
    velocities = np.zeros((3, 3))
    if before is not None and dt_s > 0:
        velocities = (positions - before.positions_m) / dt_s
    unseen = [head.unseen_s, *best.unseen_s.tolist()]
    status = tuple(_status(seconds, p.lost_after_s) for seconds in unseen)
    weight = exchange_probability(hypotheses)
    exchanged = either(shifted(weight, p.identity.exchange_log_odds), doubt)
    return Estimates(positions, covariances, velocities, status, exchanged)


def _status(unseen_s: float, lost_after_s: float) -> str:
    if unseen_s == 0:
        return "tracked"
    return "coasting" if unseen_s < lost_after_s else "lost"


def exchange_probability(hypotheses: tuple[Hypothesis, ...]) -> float:
    """Weight of the hypotheses in which right and left are exchanged beside the best."""
    totals = np.array([h.total for h in hypotheses])
    weight = np.exp(totals.min() - totals)
    means = np.array([h.means for h in hypotheses])
    best = means[int(totals.argmin())]
    same = np.linalg.norm(means - best, axis=2).sum(axis=1)
    other = np.linalg.norm(means - best[::-1], axis=2).sum(axis=1)
    return float(weight[other < same].sum() / weight.sum())
