"""Hypotheses: accounts of which hand is where, and how they grow from frame to frame."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.tracker.hypotheses.activity import share_of_motion, speed_after, tempered
from pjpdaf.tracker.hypotheses.candidates import HALF, OTHER_HALF
from pjpdaf.tracker.hypotheses.coasting import coasted, learnt_velocity
from pjpdaf.tracker.hypotheses.memory import kept_share
from pjpdaf.tracker.hypotheses.motion import log_likelihood, mixed, spread, steps, updated
from pjpdaf.tracker.hypotheses.pairs import Pairs
from pjpdaf.tracker.hypotheses.parameters import HypothesisParameters

LARGEST_COST = 14.0  # of a hypothesis beyond the best; what costs more is dropped
FORBIDDEN = 30.0
MOTION_COST_MOST = 16.0
BEHIND_WITHIN_S = 1.0  # after a hand was seen it may turn out to be behind the head
BEHIND_WITHIN_M = 0.4  # of there
SAME_M = 0.03  # hypotheses closer than this along each axis are one
REFERENCE_SD_M = 0.03  # a hand seen where it was expected, this well, costs nothing
LARGEST_VARIANCE_M2 = 0.25
SHOWN_M = 0.10  # a sighting this near to where a hand is known to be shows it


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """One account of which hand is where.

    cost: negative log-odds of motion and looks; evidence: of the sleeves, which fades; means (2, 3)
    [m] right, left; covariances (2, 3, 3) [m^2]; unseen_s (2,); parent: index of the hypothesis of
    the frame before that it comes from; halves: whether the latest sighting of right and left is
    half of a merged blob; speed_mps: of the hands lately, root mean square; velocities (2, 3)
    [m/s] of each.
    """

    cost: float
    evidence: float
    means: Floats
    covariances: Floats
    unseen_s: Floats
    parent: int = 0
    halves: tuple[bool, bool] = (False, False)
    speed_mps: float = 0.0
    velocities: Floats = field(default_factory=lambda: np.zeros((2, 3)))

    @property
    def total(self) -> float:
        """Negative log-odds."""
        return self.cost + self.evidence


@dataclass(frozen=True, eq=False)
class Sightings:
    """All choices of a hand in a frame: n pairs, at the face, unseen.

    own (n,) cost of each pair by itself; joint (n + 2, n + 2) of two together; odds (n,) that it is
    the right hand [log]; face_m (f, 3) places before the face and,
    the last, behind the head; face_cost (f,). aside_m (2, n, 3): from pairs to the palm of right
    and left.
    """

    pairs: Pairs
    own: Floats
    joint: Floats
    odds: Floats
    face_m: Floats
    face_cost: Floats
    aside_m: Floats


def nearest_choices(seen: Sightings, hands_m: Floats, held_m: Floats) -> tuple[int, int]:
    """The choices (right, left) nearest to where the hands (2, 3) are known to be.

    A pair that shows the hand comes before the place where the hand was last seen, held_m (2, 3),
    however near that is.
    """
    n = len(seen.pairs)
    chosen = []
    for hand, held in zip(hands_m, held_m, strict=True):
        places = np.concatenate([seen.pairs.points_m, seen.face_m, held[None]])
        distance = np.linalg.norm(places - hand, axis=1)
        shown = n > 0 and distance[:n].min() < SHOWN_M
        chosen.append(int(distance[: n if shown else len(distance)].argmin()))
    return chosen[0], chosen[1]


def grow(
    hypotheses: tuple[Hypothesis, ...],
    seen: Sightings,
    dt_s: float,
    p: HypothesisParameters,
    only: tuple[int, int] | None = None,
) -> tuple[tuple[Hypothesis, ...], tuple[int, int]]:
    """The likeliest hypotheses one frame later, and the choices (right, left) of the first.

    Each hypothesis goes on with every pair of choices; the best `hypotheses` of all are kept, those
    of equal places once. Costs are shifted so that the smallest is 0. only: the choices of right
    and left where they are known.
    """
    k = len(seen.face_m)
    face = np.broadcast_to(seen.face_m, (2, k, 3))
    points = np.concatenate([seen.pairs.points_m + seen.aside_m, face], axis=1)
    C_face = np.tile(np.eye(3) * p.noise.face_m**2, (k, 1, 1))
    C = np.concatenate([seen.pairs.covariances_m2, C_face])
    each = _alone(hypotheses, seen, points, C, dt_s, p)
    doubt = np.concatenate([seen.odds, np.zeros(k + 1)])
    n = len(seen.pairs)
    rows = np.array([*range(n), *[n] * k, n + 1])
    joint = seen.joint[np.ix_(rows, rows)]
    # The cost of the less likely side; the likelier costs nothing.
    against_right, against_left = np.maximum(-doubt, 0.0), np.maximum(doubt, 0.0)
    sleeve = against_right[:, None] + against_left[None, :]
    kept = np.array([h.evidence for h in hypotheses]) * _kept_share(seen.odds, dt_s, p)
    base = np.array([h.cost for h in hypotheses])[:, None, None] + joint[None]
    # Hidden hands have no place: motion says nothing of them.
    both = each[:, 0, :, None] + each[:, 1, None, :]
    speeds, totals = [h.speed_mps for h in hypotheses], [h.total for h in hypotheses]
    share = share_of_motion(speeds, totals, _told(seen.odds, p), dt_s, p.motion)
    both[:, :n, :n] = tempered(each[:, :, :n], seen.pairs.points_m, seen.face_m[0], share)
    base = base + both
    half = ((seen.pairs.part == HALF) | (seen.pairs.part == OTHER_HALF)).any(axis=1).tolist()
    half += [False] * (k + 1)
    total = base + kept[:, None, None] + sleeve[None]
    if only is not None:
        ruled_out = np.full(joint.shape, np.inf)
        ruled_out[only] = 0.0
        total = total + ruled_out
    flat = total.ravel()
    count = min(4 * p.hypotheses + 8, flat.size)
    best = np.argpartition(flat, count - 1)[:count]
    best = best[np.argsort(flat[best], kind="stable")]
    best = best[flat[best] < flat[best[0]] + LARGEST_COST]
    choices = np.transpose(np.unravel_index(best, total.shape)).tolist()
    updates = _updates(hypotheses, choices, points, C, dt_s, p)
    grown: list[Hypothesis] = []
    moved: dict[tuple[int, int, int], tuple[Floats, Floats, float, Floats]] = {}
    for k, right, left in choices:
        for way in ((k, 0, right), (k, 1, left)):
            if way not in moved:
                moved[way] = _moved(hypotheses[k], way, updates.get(way), len(C), dt_s, p)
        hands = moved[k, 0, right], moved[k, 1, left]
        means = np.array([hand[0] for hand in hands])
        if any(np.abs(g.means - means).max() < SAME_M for g in grown):
            continue
        covariances = np.array([hand[1] for hand in hands])
        unseen = np.array([hand[2] for hand in hands])
        evidence = float(kept[k] + sleeve[right, left])
        cost = float(base[k, right, left])
        halves = half[right], half[left]
        velocities = np.array([hand[3] for hand in hands])
        of, before = hypotheses[k], hypotheses[k].speed_mps
        speed = speed_after(before, of.means, means, unseen == 0, dt_s, p.motion.speed_memory_s)
        grown.append(
            Hypothesis(cost, evidence, means, covariances, unseen, k, halves, speed, velocities)
        )
        if len(grown) == p.hypotheses:
            break
    least_cost, least_evidence = min(h.cost for h in grown), min(h.evidence for h in grown)
    _, right, left = choices[0]
    after = tuple(
        replace(h, cost=h.cost - least_cost, evidence=h.evidence - least_evidence) for h in grown
    )
    return after, (right, left)


def _kept_share(odds: Floats, dt_s: float, p: HypothesisParameters) -> float:
    """Share of the evidence of earlier frames that still counts.

    It fades as far as this frame brings evidence of its own, which repeats it; a frame without any
    leaves what was known.
    """
    return 1.0 - (1.0 - kept_share(dt_s, p.sleeve.memory_s)) * _told(odds, p)


def _told(odds: Floats, p: HypothesisParameters) -> float:
    """How much evidence of right and left a frame brings, 1: the most that there can be."""
    if not len(odds) or p.sleeve.sleeve_clip <= 0:
        return 0.0
    return min(float(np.abs(odds).max()) / p.sleeve.sleeve_clip, 1.0)


def _alone(
    hypotheses: tuple[Hypothesis, ...],
    seen: Sightings,
    points: Floats,
    C: Floats,
    dt_s: float,
    p: HypothesisParameters,
) -> Floats:
    """Cost (K, 2, n + 2) of each hand's choices by themselves: motion and looks."""
    n, c = len(seen.pairs), p.costs
    means = np.array([h.means for h in hypotheses])  # (K, 2, 3)
    P = np.array([h.covariances for h in hypotheses])
    log = log_likelihood(
        points[None] - means[:, :, None],
        P[:, :, None] + C[None, None],
        p.motion.weights,
        steps(dt_s, p.motion.deviations_m),
    )
    reference = 1.5 * np.log(2 * np.pi) + 3.0 * np.log(REFERENCE_SD_M)
    motion = np.minimum(-np.logaddexp.reduce(log, axis=-1) - reference, MOTION_COST_MOST)
    unseen_s = np.array([h.unseen_s for h in hypotheses])[..., None]
    miss = np.where(unseen_s > 0, c.stay_hidden, c.miss)
    each = np.concatenate([motion, miss], axis=2)
    each[:, :, :n] += seen.own
    each[:, :, n:-1] += seen.face_cost
    # A hand that was far from the head, or gone before, went elsewhere.
    far = np.linalg.norm(means - seen.face_m[-1], axis=2) > BEHIND_WITHIN_M
    each[:, :, -2] += np.where(far | (unseen_s[..., 0] > BEHIND_WITHIN_S), FORBIDDEN, 0.0)
    return np.asarray(np.minimum(each, FORBIDDEN))


def _updates(
    hypotheses: tuple[Hypothesis, ...],
    choices: list[list[int]],
    points: Floats,
    C: Floats,
    dt_s: float,
    p: HypothesisParameters,
) -> dict[tuple[int, int, int], tuple[Floats, Floats, Floats]]:
    """What `updated` gives, all at once, of (hypothesis, side, choice) where a place is chosen.

    choices: hypothesis, choice of the right and of the left hand.
    """
    ways = {(k, 0, right) for k, right, _ in choices} | {(k, 1, left) for k, _, left in choices}
    seen = sorted(way for way in ways if way[2] < len(C))
    if not seen:
        return {}
    k, side, choice = np.transpose(seen)
    means = np.array([h.means for h in hypotheses])[k, side]
    P = np.array([h.covariances for h in hypotheses])[k, side]
    m = p.motion
    variances = steps(dt_s, m.deviations_m)
    after = updated(means, P, points[side, choice], C[choice], m.weights, variances)
    return dict(zip(seen, zip(*after, strict=True), strict=True))


def _moved(
    h: Hypothesis,
    way: tuple[int, int, int],
    update: tuple[Floats, Floats, Floats] | None,
    places: int,
    dt_s: float,
    p: HypothesisParameters,
) -> tuple[Floats, Floats, float, Floats]:
    """A hand after its choice: mean (3,), covariance (3, 3), time unseen, velocity (3,).

    way: hypothesis, side and choice, of so many places; update: as of `updated`, None of a hand
    that is unseen.
    """
    m = p.motion
    _, side, choice = way
    if update is None:
        P = h.covariances[side] + 0.5 * spread(dt_s, m.weights, m.deviations_m)
        moved_m, velocity = coasted(h.velocities[side], dt_s, m.coast_s)
        unseen_s = float(h.unseen_s[side] + dt_s)
        return h.means[side] + moved_m, np.minimum(P, LARGEST_VARIANCE_M2), unseen_s, velocity
    mean, P = mixed(*update)
    behind = choice == places - 1  # the head: believed to be there, not seen
    if behind:
        return mean, P, float(h.unseen_s[side] + dt_s), np.zeros(3)
    if h.unseen_s[side] > 0:
        return mean, P, 0.0, np.zeros(3)
    return mean, P, 0.0, learnt_velocity(h.velocities[side], mean - h.means[side], dt_s)
