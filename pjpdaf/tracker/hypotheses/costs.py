"""Costs of pairs as hands: negative log-odds of looks, alone and two together."""

from __future__ import annotations

import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.looks import Silhouette
from pjpdaf.targets import LEFT_HAND, RIGHT_HAND
from pjpdaf.tracker.hypotheses.blobs import Blobs
from pjpdaf.tracker.hypotheses.candidates import (
    BESIDE,
    END,
    HALF,
    OTHER_HALF,
    WHOLE,
    HeadPlace,
)
from pjpdaf.tracker.hypotheses.geometry import Views
from pjpdaf.tracker.hypotheses.half_fingers import fingers_of_halves
from pjpdaf.tracker.hypotheses.pairs import Pairs
from pjpdaf.tracker.hypotheses.parameters import (
    CostParameters,
    HypothesisParameters,
    SleeveParameters,
)
from pjpdaf.tracker.hypotheses.sleeve import Body, arm_scores, arm_values

AREA_COST_MOST = 6.0
HANDLIKE_COST = 3.0, 5.0  # of the area, of the pair: a blob below both should be somebody's hand
SINGLE_AREA_COST = 4.0  # the same of a blob that one view shows
LONGEST_FINGERS = 0.3
FORWARD_MOST = 4.0
MOST_PAIRS = 100  # ordinary frames have fewer than 20
FAST_M, FAR_COST_MOST = 0.32, 6.0  # distance of a fast movement, in the choice of pairs


def area_cost(pairs: Pairs, hand_area_m2: float, c: CostParameters) -> Floats:
    """Cost (n,) of areas beside that of a whole hand; an end of a bare arm has a fixed cost."""
    z = np.log(np.maximum(pairs.areas_m2, 1e-6) / hand_area_m2)
    z = z / np.where(z > 0, c.log_area_up_sd, c.log_area_sd)
    cost = np.minimum(0.5 * z * z, AREA_COST_MOST)
    cost = np.where((pairs.part >= END).any(axis=1), c.end, cost)
    half = ((pairs.part == HALF) | (pairs.part == OTHER_HALF)).any(axis=1)
    return np.asarray(cost + np.where(half, 0.5 * c.split, 0.0))


def likeliest(pairs: Pairs, expected_m: Floats, hand_area_m2: float, c: CostParameters) -> Pairs:
    """The MOST_PAIRS pairs of least cost, so that a frame's cost is bounded however many there are.

    expected_m (h, 3): where hands are expected; the distance from the nearest counts, but a hand
    that comes back far away stays possible.
    """
    if len(pairs) <= MOST_PAIRS:
        return pairs
    away_m = np.linalg.norm(pairs.points_m[:, None] - expected_m[None], axis=2).min(axis=1)
    far = np.minimum(0.5 * (away_m / FAST_M) ** 2, FAR_COST_MOST)
    cost = pairs.cost + area_cost(pairs, hand_area_m2, c) + far
    return pairs[np.sort(np.argsort(cost, kind="stable")[:MOST_PAIRS])]


def piece_cost(pairs: Pairs, head_m: Floats, axes: Floats, c: CostParameters) -> Floats:
    """Cost (n,) of what is a piece of face or neck that a beard, glasses or a collar cut off.

    The neck is behind the face, a hand before it.
    """
    off = (pairs.points_m - head_m) @ axes.T
    beside, down, away = np.abs(off[:, 0]), off[:, 1], off[:, 2]
    neck = (beside < 0.06) & (down > 0.03) & (down < 0.24) & (away > -0.03)
    neck &= pairs.areas_m2 < 0.75 * c.hand_area_m2
    whole = (pairs.part == WHOLE).any(axis=1)
    face = (beside < np.where(whole, 0.08, 0.05)) & (down > -0.16) & (down < 0.22)
    face &= (np.abs(away) < 0.25) & (pairs.areas_m2 < 0.45 * c.hand_area_m2)
    return np.where(neck | face, c.piece, 0.0)


def end_cost(pairs: Pairs, axes: Floats, c: CostParameters) -> Floats:
    """Cost (n,) of taking an end of a bare arm for the hand while the other end is nearer.

    The other end is the elbow, which a hand at work is before.
    """
    cost = np.zeros(len(pairs))
    for i in np.flatnonzero((pairs.part >= END).all(axis=1)):
        mate = (pairs.blob == pairs.blob[i]).all(axis=1)
        mate &= (pairs.part == 2 * END + 1 - pairs.part[i]).all(axis=1)
        if mate.any():
            nearer = float((pairs.points_m[i] - pairs.points_m[int(mate.argmax())]) @ axes[2])
            cost[i] = min(max(nearer, 0.0) / c.forward_m, FORWARD_MOST)
    return cost


def joint_cost(
    pairs: Pairs,
    places: tuple[HeadPlace | None, ...],
    hand_area_m2: float,
    c: CostParameters,
) -> Floats:
    """Cost (n + 2, n + 2) of right and left choices together; n: at the face, n + 1: unseen."""
    n = len(pairs)
    joint = np.zeros((n + 2, n + 2))
    if n == 0:
        return joint
    for view in range(2):
        b, part = pairs.blob[:, view], pairs.part[:, view]
        same = (b[:, None] == b[None, :]) & (b >= 0)[:, None] & (b >= 0)[None, :]
        chosen = pairs.candidate[:, view]
        same_part = same & (chosen[:, None] == chosen[None, :])
        whole = (part == WHOLE)[:, None] | (part == WHOLE)[None, :]
        ends = (part >= END)[:, None] & (part >= END)[None, :]
        half = (part == HALF) | (part == OTHER_HALF)
        lone = half[:, None] & ~same
        pair = joint[:n, :n]
        pair += np.where(same_part, 0.5 * c.same_blob + 1.0, 0.0)
        pair += np.where(same & ~same_part & whole, 0.5 * c.same_blob, 0.0)
        pair += np.where(same & ~same_part & ends, c.same_blob, 0.0)
        end_and_half = (part >= END)[:, None] & half[None, :]
        pair += np.where(same & (end_and_half | end_and_half.T), 0.5 * c.end_and_half, 0.0)
        pair += 0.5 * c.lone_half * (lone.astype(float) + lone.T.astype(float))
        joint[:n, n:] += 0.5 * c.lone_half * half[:, None]
        joint[n:, :n] += 0.5 * c.lone_half * half[None, :]
    plain = (pairs.part == WHOLE).all(axis=1)
    plain &= area_cost(pairs, hand_area_m2, c) < HANDLIKE_COST[0]
    plain &= pairs.cost < HANDLIKE_COST[1]
    # A bare arm has a hand too.
    plain |= (pairs.part >= END).all(axis=1) & (pairs.cost < HANDLIKE_COST[1])
    heads = [place.blob if place is not None else -1 for place in places]
    for left, right in {(int(a), int(b)) for a, b in pairs.blob[plain]}:
        if left != heads[0] and right != heads[1]:
            joint += c.unexplained * _unexplained(pairs, left, right)
    single = ((pairs.part == WHOLE) | (pairs.part == -1)).all(axis=1)
    single &= (pairs.blob < 0).any(axis=1)
    single &= area_cost(pairs, hand_area_m2, c) < SINGLE_AREA_COST
    for left, right in {(int(a), int(b)) for a, b in pairs.blob[single]}:
        joint += c.unexplained_single * _unexplained(pairs, left, right)
    beside = (pairs.part == BESIDE).all(axis=1)
    for left, right in {(int(a), int(b)) for a, b in pairs.blob[beside]}:
        joint += 0.5 * c.unexplained * _unused_at_face(pairs, left, right)
    return joint


def _unexplained(pairs: Pairs, left: int, right: int) -> Floats:
    """1 where the two choices leave one of these blobs unused, (n + 2, n + 2).

    Each view by itself: a false pair of one thing's left blob and another's right explains neither.
    """
    unused = np.zeros((len(pairs) + 2, len(pairs) + 2), bool)
    for view, blob in enumerate((left, right)):
        if blob < 0:  # this view does not show it
            continue
        uses = np.concatenate([pairs.blob[:, view] == blob, [False, False]])
        unused |= ~(uses[:, None] | uses[None, :])
    return unused.astype(np.float64)


def _unused_at_face(pairs: Pairs, left: int, right: int) -> Floats:
    """1 where neither choice uses a piece beside the head, (n + 2, n + 2); 'at the face' does."""
    used = (pairs.blob[:, 0] == left) | (pairs.blob[:, 1] == right)
    uses = np.concatenate([used, [True, False]])
    return np.asarray(~(uses[:, None] | uses[None, :]), dtype=np.float64)


def finger_directions(
    pairs: Pairs, seen: tuple[Blobs, ...], views: Views, s: SleeveParameters
) -> Floats:
    """Which way the fingers of each pair point in each view, (2, n, 2); 0 where unknown.

    Of an end of a bare arm it is the way from the arm's middle.
    """
    fingers = np.zeros((2, len(pairs), 2))
    pixels, _ = views.project(pairs.points_m)
    for v, view in enumerate(seen):
        whole = np.flatnonzero(pairs.part[:, v] == WHOLE)
        looks, blob = view.looks, pairs.blob[whole, v]
        wrist = looks.palms[blob] - looks.fingers[blob]
        fingers[v, whole] = looks.fingers[blob] - s.wrist_share * wrist
        end = np.flatnonzero(pairs.part[:, v] >= END)
        way = pixels[v, end] - view.centres_px[pairs.blob[end, v]]
        length = np.maximum(np.linalg.norm(way, axis=1, keepdims=True), 1e-6)
        fingers[v, end] = s.bare_arm_fingers * way / length
    return np.clip(fingers, -LONGEST_FINGERS, LONGEST_FINGERS)


def side_evidence(
    pairs: Pairs,
    seen: tuple[Blobs, ...],
    head_m: Floats,
    views: Views,
    p: HypothesisParameters,
    hand_area_m2: float,
    bare: bool = False,
) -> Floats:
    """Log-odds (n,) that the hand at each pair is the right one: its sleeve, and the detector's.

    hand_area_m2: of a whole hand; bare: the forearms have no sleeves.
    """
    s = p.sleeve
    odds = np.zeros(len(pairs))
    if len(pairs) == 0:
        return odds
    shapes: tuple[Silhouette | None, ...] = tuple(view.looks.silhouette for view in seen)
    if s.sleeve_weight > 0 and any(shape is not None for shape in shapes):
        body = Body.under(head_m, views.axes, s)
        fingers = finger_directions(pairs, seen, views, s)
        if s.half_fingers > 0 and not bare:
            halves = fingers_of_halves(pairs, seen, views, hand_area_m2, s)
            fingers += np.clip(halves, -LONGEST_FINGERS, LONGEST_FINGERS)
        scores = arm_scores(
            pairs.points_m,
            arm_values(shapes, views, body, s, bare),
            shapes,
            views,
            body,
            s,
            fingers,
        )
        odds = s.sleeve_weight * (scores[:, 0] - scores[:, 1])
    for v, view in enumerate(seen):
        if view.evidence is not None and view.evidence.shape[1] > LEFT_HAND:
            whole = np.flatnonzero(pairs.part[:, v] == WHOLE)
            likelihoods = np.maximum(view.evidence[pairs.blob[whole, v]], -2.0 * s.sleeve_clip)
            odds[whole] += 0.5 * (likelihoods[:, RIGHT_HAND] - likelihoods[:, LEFT_HAND])
    return np.clip(odds, -s.sleeve_clip, s.sleeve_clip)
