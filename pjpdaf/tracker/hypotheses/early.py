"""Early sightings: before the start, the head, and the one hand that is seen.

A start needs head and both hands apart. While a hand is hidden, or both are in one blob, the rest
is told already; each frame by itself, so that a wrong look at one frame harms no other.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.interfaces import Estimates
from pjpdaf.targets import HEAD, LEFT_HAND, RIGHT_HAND
from pjpdaf.tracker.hypotheses.blobs import Blobs
from pjpdaf.tracker.hypotheses.centres import outward
from pjpdaf.tracker.hypotheses.costs import area_cost
from pjpdaf.tracker.hypotheses.geometry import Views
from pjpdaf.tracker.hypotheses.head import HeadTrack, crown_of
from pjpdaf.tracker.hypotheses.opening import (
    Hands,
    first_pairs,
    hands_below,
    head_cost,
    head_track,
)
from pjpdaf.tracker.hypotheses.pairs import Pairs
from pjpdaf.tracker.hypotheses.parameters import HypothesisParameters

LARGEST_HEAD_COST = 1.2  # of its area and of the pair, of a head that nothing below it confirms
HAND_COSTS = 1.5, 3.0  # of the area, of the pair: a lone hand must look like one
SIDE_M, SIDE_MOST = 0.1, 1.5  # a hand so far to its own side has log-odds of 1; at the most
NAMED = 1.5  # log-odds of a hand that is given its name


@dataclass(frozen=True, eq=False)
class Early:
    """What is known before the start: estimates, of which at least one is still waiting."""

    estimates: Estimates


def early_sightings(seen: tuple[Blobs, ...], views: Views, p: HypothesisParameters) -> Early | None:
    """The head, and a hand that can be named, in a frame that shows no start; None without any."""
    if any(view.missing or len(view) == 0 for view in seen):
        return None
    pairs, longest = first_pairs(seen, views, p)
    head = _head(pairs, seen, views)
    if head is None:
        return None
    number, track = head
    estimates = Estimates.waiting()
    positions, P = estimates.positions_m.copy(), estimates.covariances_m2.copy()
    velocities, status = estimates.velocities_mps.copy(), list(estimates.status)

    def put(target: int, position_m: Floats, covariance_m2: Floats) -> None:
        positions[target], P[target] = position_m, covariance_m2
        velocities[target], status[target] = 0.0, "tracked"

    own = p.offsets.head_offset_sd_m
    put(HEAD, track.centre(views.axes, p), track.covariance + np.eye(3) * own**2)
    named = _hand(pairs, number, hands_below(pairs, number, seen, views, longest, p), p)
    if named is not None:
        target, pair = named
        offset = np.array(p.offsets.hand_offset_m) @ views.axes
        offset += outward(pairs.part, seen, views.axes, p.offsets)[target - RIGHT_HAND, pair]
        own = p.offsets.hand_offset_sd_m
        put(target, pairs.points_m[pair] + offset, pairs.covariances_m2[pair] + np.eye(3) * own**2)
    return Early(Estimates(positions, P, velocities, tuple(status)))


def _head(pairs: Pairs, seen: tuple[Blobs, ...], views: Views) -> tuple[int, HeadTrack] | None:
    """The highest pair of a head's size with hair above it, at the silhouette's top; its track."""
    cost = head_cost(pairs)
    up = -(pairs.points_m @ views.axes[1])
    for i in np.argsort(-up, kind="stable"):
        if cost[i] > LARGEST_HEAD_COST:
            continue
        track = head_track(pairs, int(i), seen, views)
        return (int(i), track) if crown_of(track.mean, seen, views) is not None else None
    return None


def _hand(pairs: Pairs, head: int, hands: Hands, p: HypothesisParameters) -> tuple[int, int] | None:
    """Target and pair of the only hand in sight, None where there are two or its name is unsure."""
    looks = area_cost(pairs, p.costs.hand_area_m2, p.costs)
    likely = hands.good & (looks < HAND_COSTS[0]) & (hands.own - looks < HAND_COSTS[1])
    if not likely.any():
        return None
    best = int(np.where(likely, hands.own, np.inf).argmin())
    if (likely & (pairs.blob != pairs.blob[best]).all(axis=1)).any():
        return None
    most = p.sleeve.sleeve_clip
    odds = p.sleeve.sleeve_weight * float(hands.scores[best, 0] - hands.scores[best, 1])
    odds = float(np.clip(odds, -most, most))
    odds -= float(np.clip(hands.aside_m[best] / SIDE_M, -SIDE_MOST, SIDE_MOST))
    if abs(odds) < NAMED:
        return None
    return (RIGHT_HAND if odds > 0 else LEFT_HAND), best
