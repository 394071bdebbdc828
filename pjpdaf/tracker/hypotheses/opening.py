"""First positions: three blobs that both views agree on, the head above, hands apart."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import combinations, permutations

import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Floats
from pjpdaf.tracker.hypotheses.arm_pieces import forearm_cost
from pjpdaf.tracker.hypotheses.attached import apart_cost, attached
from pjpdaf.tracker.hypotheses.blobs import Blobs
from pjpdaf.tracker.hypotheses.candidates import END, WHOLE, HeadPlace, candidates
from pjpdaf.tracker.hypotheses.centres import CROWN_M, outward
from pjpdaf.tracker.hypotheses.costs import area_cost, end_cost, finger_directions
from pjpdaf.tracker.hypotheses.geometry import Views
from pjpdaf.tracker.hypotheses.hair_beside import hair_beside
from pjpdaf.tracker.hypotheses.head import HeadTrack, crown_of, head_size
from pjpdaf.tracker.hypotheses.pairs import Pairs, pair_candidates
from pjpdaf.tracker.hypotheses.parameters import HypothesisParameters
from pjpdaf.tracker.hypotheses.sleeve import Body, arm_scores, arm_values

HEAD_AREA_M2, HEAD_LOG_SD = 0.024, 0.4  # of visible skin, with the neck
LARGEST_HEAD_Z = 3.0
HEIGHT_PRIOR = 4.0  # cost of a metre lower, for the head
BELOW_M = 0.05, 0.08  # hands below the head; blobs that count as below it
USUAL_DEPTH_M = 1.2
APART_M = 0.12  # hands nearer to each other may be two pieces of one arm
REACH_M = 0.85  # from the head
BEHIND_M = 0.2  # the head
WRONG_SIDE = 3.0  # cost of a right hand on the left of the left hand
WHOLE_ARM = 4.0  # cost of a whole bare arm, whose hand is an end
LARGEST_COST = 8.0
HEAD_SD_M = 0.02


@dataclass(frozen=True, eq=False)
class Opening:
    """The head's track; hands: places (2, 3) [m] of right and left with their costs, the likeliest
    first; longest_m: length of the longest blob that may be a hand.
    """

    head: HeadTrack
    hands: tuple[tuple[Floats, float], ...]
    longest_m: float


def open_tracks(seen: tuple[Blobs, ...], views: Views, p: HypothesisParameters) -> Opening | None:
    """The opening, or None: wait for a frame that shows head and hands apart."""
    if any(view.missing or len(view) < 3 for view in seen):
        return None
    pairs, longest = first_pairs(seen, views, p)
    head = _head(pairs, views)
    if head is None:
        return None
    track = head_track(pairs, head, seen, views)
    hands = _hands(pairs, hands_below(pairs, head, seen, views, longest, p), seen, views, p)
    return Opening(track, hands, longest) if hands else None


def first_pairs(
    seen: tuple[Blobs, ...], views: Views, p: HypothesisParameters
) -> tuple[Pairs, float]:
    """Sightings of head and hands that nothing is known of; length [m] of the longest blob that
    may be a hand.
    """
    metre_px = views.focal_px / USUAL_DEPTH_M
    longest = _longest(seen, metre_px)
    plain = replace(p.candidates, halves=False, beside_head=False)
    one, two = (
        candidates(
            view,
            None,
            float(metre_px[v]),
            p.costs.hand_area_m2,
            longest > plain.bare_length_m,
            plain,
        )
        for v, view in enumerate(seen)
    )
    return pair_candidates(views, (one, two), np.zeros((0, 3)), p.noise, p.costs), longest


def _longest(seen: tuple[Blobs, ...], metre_px: Floats) -> float:
    lengths = [
        view.length_m(i, float(metre_px[v]))
        for v, view in enumerate(seen)
        for i in range(len(view))
        if view.centres_px[i, 1] > view.centres_px[:, 1].min() + 0.12 * metre_px[v]
    ]
    return max(lengths, default=0.0)


def _head(pairs: Pairs, views: Views) -> int | None:
    """The pair of a head's size that is high up, with two others below it."""
    up = -(pairs.points_m @ views.axes[1])
    own = head_cost(pairs)
    best: tuple[float, int] | None = None
    for i in np.flatnonzero(np.isfinite(own)):
        if (up < up[i] - BELOW_M[1]).sum() < 2:
            continue
        cost = float(own[i] - HEIGHT_PRIOR * up[i])
        if best is None or cost < best[0]:
            best = cost, int(i)
    return None if best is None else best[1]


def head_cost(pairs: Pairs) -> Floats:
    """Cost (n,) of pairs as a head, infinite of parts and of what is far from a head's size."""
    z = np.log(np.maximum(pairs.areas_m2, 1e-9) / HEAD_AREA_M2) / HEAD_LOG_SD
    good = (pairs.part == WHOLE).all(axis=1) & (np.abs(z) <= LARGEST_HEAD_Z)
    return np.asarray(np.where(good, 0.5 * z * z + pairs.cost, np.inf))


def head_track(pairs: Pairs, head: int, seen: tuple[Blobs, ...], views: Views) -> HeadTrack:
    """A track that begins with a pair."""
    one, two = (
        HeadPlace(int(b), True, view.centres_px[b], np.eye(2))
        for b, view in zip(pairs.blob[head], seen, strict=True)
    )
    # Without the palm's offset, which is a hand's.
    mean = views.triangulate(one.centre_px[None], two.centre_px[None])[0][0]
    area, shape = head_size(mean, seen, (one, two), views)
    crown = crown_of(mean, seen, views) or CROWN_M
    beside = hair_beside(mean, seen, views)
    return HeadTrack(mean, np.eye(3) * HEAD_SD_M**2, area, shape, crown, beside)


@dataclass(frozen=True, eq=False)
class Hands:
    """Pairs (n,) as hands of a head above them.

    good (n,): within reach of it; own (n,): cost of each by itself; scores (n, 2) of the arms from
    right and left shoulder; aside_m (n,): from the head to the right of the picture.
    """

    good: NDArray[np.bool_]
    own: Floats
    scores: Floats
    aside_m: Floats


def hands_below(
    pairs: Pairs,
    head: int,
    seen: tuple[Blobs, ...],
    views: Views,
    longest_m: float,
    p: HypothesisParameters,
) -> Hands:
    """What speaks for each pair as a hand below the head, a pair itself."""
    off = (pairs.points_m - pairs.points_m[head]) @ views.axes.T
    good = (
        (off[:, 1] > BELOW_M[0])
        & (off[:, 2] < BEHIND_M)
        & (np.linalg.norm(off, axis=1) < REACH_M)
        & (pairs.blob != pairs.blob[head]).all(axis=1)
    )
    body = Body.under(pairs.points_m[head], views.axes, p.sleeve)
    shapes = tuple(view.looks.silhouette for view in seen)
    long = longest_m > p.candidates.bare_length_m
    values = arm_values(shapes, views, body, p.sleeve, long)
    fingers = finger_directions(pairs, seen, views, p.sleeve)
    scores = arm_scores(pairs.points_m, values, shapes, views, body, p.sleeve, fingers)
    own = pairs.cost + area_cost(pairs, p.costs.hand_area_m2, p.costs)
    if p.costs.apart > 0:
        hangs = attached(seen, pairs.points_m[head], views)
        own = own + apart_cost(pairs, hangs, 1.0, p.costs.apart)
    bare = long or all(shape is None for shape in shapes)
    if long:
        own = own + end_cost(pairs, views.axes, p.costs) + WHOLE_ARM * _whole_arms(pairs)
    if bare and p.candidates.arm_pieces:
        own = own + forearm_cost(pairs, good, views.axes, p.costs.forward_m)
    return Hands(good, own, scores, np.asarray(off[:, 0]))


def _hands(
    pairs: Pairs, of: Hands, seen: tuple[Blobs, ...], views: Views, p: HypothesisParameters
) -> tuple[tuple[Floats, float], ...]:
    hands: list[tuple[Floats, float]] = []
    palms = pairs.points_m + outward(pairs.part, seen, views.axes, p.offsets)
    for pair in combinations(np.flatnonzero(of.good).tolist(), 2):
        if (pairs.blob[pair[0]] == pairs.blob[pair[1]]).any():
            continue
        if np.linalg.norm(pairs.points_m[pair[0]] - pairs.points_m[pair[1]]) < APART_M:
            continue
        for right, left in permutations(pair):
            cost = float(of.own[right] + of.own[left])
            cost -= p.sleeve.sleeve_weight * float(of.scores[right, 0] + of.scores[left, 1])
            cost += WRONG_SIDE if of.aside_m[left] < of.aside_m[right] else 0.0
            hands.append((palms[[0, 1], [right, left]], cost))
    hands.sort(key=lambda hand: hand[1])
    least = hands[0][1] if hands else 0.0
    near = [(points, cost - least) for points, cost in hands if cost < least + LARGEST_COST]
    return tuple(near[: p.hypotheses])


def _whole_arms(pairs: Pairs) -> NDArray[np.bool_]:
    """Which pairs (n,) are whole blobs that are bare arms in either view: the hand is an end."""
    arms = np.zeros(len(pairs), np.bool_)
    for view in range(pairs.blob.shape[1]):
        of_ends = pairs.blob[pairs.part[:, view] >= END, view]
        arms |= (pairs.part[:, view] == WHOLE) & np.isin(pairs.blob[:, view], of_ends)
    return arms
