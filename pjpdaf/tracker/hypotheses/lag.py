"""Fixed-lag smoothing: an earlier frame in the knowledge of the hypotheses that came after it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.interfaces import Estimates
from pjpdaf.tracker.hypotheses.geometry import Views
from pjpdaf.tracker.hypotheses.head import HeadTrack
from pjpdaf.tracker.hypotheses.hypothesis import Hypothesis
from pjpdaf.tracker.hypotheses.motion import spread
from pjpdaf.tracker.hypotheses.parameters import HypothesisParameters
from pjpdaf.tracker.hypotheses.readout import read_out

NO_LINE = 3.0  # cost beyond the unlikeliest of the last frame


@dataclass(frozen=True, eq=False)
class Past:
    """Head and hypotheses of a frame; dt_s: time since the frame before."""

    head: HeadTrack
    hypotheses: tuple[Hypothesis, ...]
    dt_s: float


def look_back(
    frames: Sequence[Past],
    filtered: Estimates,
    views: Views,
    p: HypothesisParameters,
    doubt: float = 0.0,
) -> Estimates:
    """Estimates of the first of successive frames; filtered: its own, without the later ones.

    doubt: as of `read_out`.

    Each hypothesis of the last frame has one line of ancestors. The hands of an ancestor are
    smoothed along its likeliest line (Rauch, Tung, Striebel 1965), and what its lines cost after it
    counts by `later_share`; one without a line costs more than any.
    """
    if len(frames) == 1:
        return filtered
    head = _smoothed_head(frames, p)
    lines: dict[int, list[tuple[int, ...]]] = {}
    for h in range(len(frames[-1].hypotheses)):
        line = _line(frames, h)
        lines.setdefault(line[0], []).append(line)
    smoothed = tuple(
        _smoothed_hands(frames, k, lines.get(k, []), p) for k in range(len(frames[0].hypotheses))
    )
    estimates = read_out(head, smoothed, None, views, 0.0, p, doubt)
    moved = estimates.positions_m - filtered.positions_m
    # Later frames may tell that the hands were taken for each other.
    hands = estimates.positions_m[1:]
    straight = np.linalg.norm(moved[1:], axis=1).sum()
    exchanged = np.linalg.norm(hands - filtered.positions_m[[2, 1]], axis=1).sum()
    rows = [0, 2, 1] if exchanged < straight else [0, 1, 2]
    return replace(estimates, velocities_mps=filtered.velocities_mps[rows])


def _line(frames: Sequence[Past], last: int) -> tuple[int, ...]:
    """Place of each ancestor among the hypotheses of its frame, up to the hypothesis `last`."""
    line = [last]
    for after in frames[:0:-1]:
        line.append(after.hypotheses[line[-1]].parent)
    return tuple(line[::-1])


def _smoothed_hands(
    frames: Sequence[Past], k: int, lines: Sequence[tuple[int, ...]], p: HypothesisParameters
) -> Hypothesis:
    """Hypothesis k of the first frame with what the lines that start at it say."""
    first, last = frames[0].hypotheses[k], frames[-1].hypotheses
    if lines:
        totals = np.array([last[line[-1]].total for line in lines])
        cost = -float(np.logaddexp.reduce(-totals))
        first = _along(frames, lines[int(totals.argmin())], p)
    else:
        cost = max(h.total for h in last) + NO_LINE
    return replace(first, cost=first.total + p.later_share * (cost - first.total), evidence=0.0)


def _along(frames: Sequence[Past], line: Sequence[int], p: HypothesisParameters) -> Hypothesis:
    """The first hypothesis of a line, its hands smoothed."""
    m = p.motion
    hypotheses = [frame.hypotheses[k] for frame, k in zip(frames, line, strict=True)]
    mean, P = hypotheses[-1].means, hypotheses[-1].covariances
    for before, after in zip(hypotheses[-2::-1], frames[:0:-1], strict=True):
        Q = spread(after.dt_s, m.weights, m.deviations_m)
        hands = [_back(before.means[i], before.covariances[i], mean[i], P[i], Q) for i in range(2)]
        mean, P = np.array([h[0] for h in hands]), np.array([h[1] for h in hands])
    return replace(hypotheses[0], means=mean, covariances=P)


def _smoothed_head(frames: Sequence[Past], p: HypothesisParameters) -> HeadTrack:
    m = p.motion
    mean, P = frames[-1].head.mean, frames[-1].head.covariance
    for before, after in zip(frames[-2::-1], frames[:0:-1], strict=True):
        Q = spread(after.dt_s, m.head_weights, m.head_deviations_m)
        mean, P = _back(before.head.mean, before.head.covariance, mean, P, Q)
    return replace(frames[0].head, mean=mean, covariance=P)


def _back(
    mean: Floats, P: Floats, mean_after: Floats, P_after: Floats, Q: Floats
) -> tuple[Floats, Floats]:
    """A filtered mean (3,) and covariance (3, 3) in the knowledge of the smoothed next ones.

    Q: covariance of the displacement between them.
    """
    predicted = P + Q
    G = P @ np.linalg.inv(predicted)
    smooth = P + G @ (P_after - predicted) @ G.T
    return mean + G @ (mean_after - mean), np.asarray(0.5 * (smooth + smooth.T))
