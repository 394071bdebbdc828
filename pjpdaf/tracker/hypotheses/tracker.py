"""Hypothesis tracker: head, right hand and left hand over joint configurations."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import final

import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.camera import Camera
from pjpdaf.detector.blob_detector import BlobDetections
from pjpdaf.interfaces import Estimates
from pjpdaf.tracker.hypotheses.candidates import (
    BESIDE,
    END,
    HALF,
    WHOLE,
    Head,
    Pairs,
    blob_length_m,
    candidates,
    pairs,
)
from pjpdaf.tracker.hypotheses.geometry import Views
from pjpdaf.tracker.hypotheses.head import HeadTrack, follow_head
from pjpdaf.tracker.hypotheses.motion import correct, log_likelihood, spread, steps
from pjpdaf.tracker.hypotheses.parameters import HypothesisParameters
from pjpdaf.tracker.hypotheses.sleeve import Body, arm_scores, arm_values
from pjpdaf.tracker.hypotheses.opening import open_tracks

LARGEST_COST = 14.0  # of a hypothesis beyond the best; more is dropped
FORBIDDEN = 30.0
LENGTH_MEMORY_S = 4.0


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """One account of which hand is where.

    cost: negative log-odds of motion and looks; evidence: the sleeves' part, which fades;
    means (2, 3) [m] right, left; covariances (2, 3, 3); unseen_s (2,).
    """

    cost: float
    evidence: float
    means: Floats
    covariances: Floats
    unseen_s: Floats

    @property
    def total(self) -> float:
        return self.cost + self.evidence


@dataclass(frozen=True, eq=False)
class HypothesisState:
    """All that changes: the head's track, hypotheses from the likeliest, the last estimates."""

    head: HeadTrack
    hypotheses: tuple[Hypothesis, ...]
    said: Estimates
    hand_area_m2: float
    longest_m: float
    exchanged: float = 0.0


@final
class HypothesisTracker:
    """Tracker of head and hands in two calibrated views; all that changes is in the state."""

    def __init__(
        self, cameras: tuple[Camera, ...], parameters: HypothesisParameters | None = None
    ) -> None:
        self.cameras = tuple(cameras)
        self.parameters = parameters if parameters is not None else HypothesisParameters()
        self.views = Views.of(self.cameras)

    def start(self, seen: tuple[BlobDetections, ...]) -> HypothesisState | None:
        opened = open_tracks(seen, self.views, self.parameters)
        if opened is None:
            return None
        head, starts, length = opened
        P = np.tile(np.eye(3) * 0.02**2, (2, 1, 1))
        found = tuple(
            Hypothesis(0.0, cost, points, P, np.zeros(2))
            for points, cost in sorted(starts, key=lambda s: s[1])
        )
        return self._state(head, found, None, 0.0, self.parameters.costs.hand_area_m2, length)

    def estimates(self, state: HypothesisState) -> Estimates:
        return state.said

    def predict(self, state: HypothesisState, dt_s: float) -> Estimates:
        p = self.parameters.motion
        extra = [spread(dt_s, p.head_weights, p.head_deviations_m)] + [
            spread(dt_s, p.weights, p.deviations_m)
        ] * 2
        return replace(state.said, covariances_m2=state.said.covariances_m2 + np.array(extra))

    def step(
        self, state: HypothesisState, seen: tuple[BlobDetections, ...], dt_s: float
    ) -> tuple[HypothesisState, Estimates]:
        p = self.parameters
        head, places = follow_head(state.head, seen, self.views, dt_s, p)
        expected = np.concatenate([h.means for h in state.hypotheses])
        bare = state.longest_m > p.candidates.bare_length_m
        found = self._pairs(seen, places, head, expected, bare)
        evidence = self._evidence(found, seen, head)
        grown, area = self._grow(state, found, evidence, seen, places, head, dt_s)
        length = self._longest(state, seen, places, head, after_s=dt_s)
        after = self._state(head, grown, state, dt_s, area, length)
        return after, after.said

    def _pairs(
        self,
        seen: tuple[BlobDetections, ...],
        places: tuple[Head | None, ...],
        head: HeadTrack,
        expected_m: Floats,
        bare: bool,
    ) -> Pairs:
        p = self.parameters
        _, depth = self.views.project(head.mean)
        each = tuple(
            candidates(
                view,
                place,
                max(float(depth[v]) - 0.15, 0.3),
                float(self.views.focal_px[v]),
                bare,
                p.candidates,
            )
            for v, (view, place) in enumerate(zip(seen, places, strict=True))
        )
        found = pairs(self.views, (each[0], each[1]), expected_m, p.noise, p.costs)
        # Hands are in front of the head, by an arm at most, and not far behind it.
        off = (found.points_m - head.mean) @ self.views.axes.T
        found = found[(off[:, 2] < 0.3) & (off[:, 2] > -0.9)]
        off = (found.points_m - head.mean) @ self.views.axes.T
        # Pieces of the face or neck that a beard, glasses or a collar cut off; the neck is behind
        # the face, a hand before it.
        below = (np.abs(off[:, 0]) < 0.06) & (off[:, 1] > 0.03) & (off[:, 1] < 0.24)
        neck = below & (off[:, 2] > -0.03) & (found.areas_m2 < 0.75 * p.costs.hand_area_m2)
        piece = (
            (np.abs(off[:, 0]) < np.where((found.part == WHOLE).any(axis=1), 0.08, 0.05))
            & (off[:, 1] > -0.16)
            & (off[:, 1] < 0.22)
            & (np.abs(off[:, 2]) < 0.25)
            & (found.areas_m2 < 0.45 * p.costs.hand_area_m2)
        )
        piece |= neck
        cost = found.cost + np.where(piece, p.costs.piece, 0.0)
        return replace(found, cost=cost)

    def _longest(
        self,
        state: HypothesisState,
        seen: tuple[BlobDetections, ...],
        places: tuple[Head | None, ...],
        head: HeadTrack,
        after_s: float,
    ) -> float:
        """Mean length of the longer hand's blob while the hands are apart, slowly forgotten."""
        longest = 0.0
        hands = state.hypotheses[0].means
        if np.linalg.norm(hands[0] - hands[1]) < 0.3:
            return state.longest_m
        pixels, depth = self.views.project(hands)
        for v, (view, place) in enumerate(zip(seen, places, strict=True)):
            for hand in range(2):
                if len(view) == 0:
                    continue
                blob = int(np.linalg.norm(view.centres_px - pixels[v, hand], axis=1).argmin())
                near = np.linalg.norm(view.centres_px[blob] - pixels[v, hand])
                metre_px = self.views.focal_px[v] / depth[v, hand]
                if near < 0.15 * metre_px and (place is None or place.blob != blob):
                    length = blob_length_m(
                        view, blob, float(depth[v, hand]), float(self.views.focal_px[v])
                    )
                    if length < 0.45:
                        longest = max(longest, length)
        if longest == 0.0:
            return state.longest_m
        share = 1.0 - float(np.exp(-after_s / LENGTH_MEMORY_S))
        return state.longest_m + share * (longest - state.longest_m)

    def _evidence(
        self, found: Pairs, seen: tuple[BlobDetections, ...], head: HeadTrack
    ) -> Floats:
        """Log-odds (n,) that the hand at each pair is the right one, by its sleeve."""
        s = self.parameters.sleeve
        if s.weight <= 0 or len(found) == 0:
            return np.zeros(len(found))
        body = Body.under(head.mean, self.views.axes, s)
        shapes = tuple(view.silhouette for view in seen)
        values = arm_values(shapes, self.views, body, s)
        step_px = [shape.step_px if shape is not None else 1 for shape in shapes]
        fingers = np.zeros((2, len(found), 2))
        for v, view in enumerate(seen):
            whole = np.flatnonzero(found.part[:, v] == WHOLE)
            if view.fingers is not None and len(view):
                fingers[v, whole] = np.clip(view.fingers[found.blob[whole, v]], -0.3, 0.3)
        scores = arm_scores(found.points_m, values, step_px, self.views, body, s, fingers)
        return np.clip(s.weight * (scores[:, 0] - scores[:, 1]), -s.clip, s.clip)

    def _grow(
        self,
        state: HypothesisState,
        found: Pairs,
        evidence: Floats,
        seen: tuple[BlobDetections, ...],
        places: tuple[Head | None, ...],
        head: HeadTrack,
        dt_s: float,
    ) -> tuple[tuple[Hypothesis, ...], float]:
        p, n = self.parameters, len(found)
        K = len(state.hypotheses)
        means = np.array([h.means for h in state.hypotheses])  # (K, 2, 3)
        P = np.array([h.covariances for h in state.hypotheses])
        own = found.cost + _area_cost(found, state.hand_area_m2, p)
        face_C = np.eye(3) * p.noise.face_m**2
        face = head.mean - 0.06 * self.views.axes[2] + 0.02 * self.views.axes[1]
        near_head = any(place is not None and not place.free for place in places) or head.unseen_s > 0
        points = np.concatenate([found.points_m, face[None]])
        C = np.concatenate([found.covariances_m2, face_C[None]])
        variances = steps(dt_s, p.motion.deviations_m)
        S = P[:, :, None] + C[None, None]
        log = log_likelihood(
            points[None, None] - means[:, :, None], S, p.motion.weights, variances
        )
        motion = -np.logaddexp.reduce(log, axis=-1)  # (K, 2, n + 1)
        # A hand seen where expected, with the noise of a whole blob, costs nothing.
        reference = 1.5 * np.log(2 * np.pi) + np.log(0.03**3)
        motion = np.minimum(motion - reference, 16.0)
        unseen_s = np.array([h.unseen_s for h in state.hypotheses])[..., None]
        miss = np.where(unseen_s > 0, p.costs.stay_hidden, p.costs.miss)
        each = np.concatenate([motion, miss], axis=2)
        each[:, :, :n] += own
        each[:, :, n] += p.costs.face if near_head else FORBIDDEN
        each = np.minimum(each, FORBIDDEN)
        doubt = np.concatenate([evidence, [0.0, 0.0]])
        joint = _joint_cost(found, seen, places, state.hand_area_m2, p)
        sleeve = -doubt[:, None] * 0.5 + doubt[None, :] * 0.5
        sleeve = sleeve + 0.5 * (np.abs(doubt)[:, None] + np.abs(doubt)[None, :])
        fade = float(np.exp(-dt_s / p.sleeve.memory_s)) if p.sleeve.memory_s > 0 else 0.0
        before_cost = np.array([h.cost for h in state.hypotheses])
        before_evidence = np.array([h.evidence for h in state.hypotheses]) * fade
        base = (
            before_cost[:, None, None]
            + each[:, 0, :, None]
            + each[:, 1, None, :]
            + joint[None]
        )
        total = base + before_evidence[:, None, None] + sleeve[None]
        flat = total.ravel()
        count = min(4 * p.hypotheses + 8, flat.size)
        best = np.argpartition(flat, count - 1)[:count]
        best = best[np.argsort(flat[best], kind="stable")]
        best = best[flat[best] < flat[best[0]] + LARGEST_COST]
        grown: list[Hypothesis] = []
        cache: dict[tuple[int, int, int], tuple[Floats, Floats, float]] = {}
        for index in best:
            k, r, left = np.unravel_index(index, total.shape)
            h = state.hypotheses[k]
            new_means, new_P, unseen = np.empty((2, 3)), np.empty((2, 3, 3)), np.zeros(2)
            for side, choice in enumerate((int(r), int(left))):
                key = (int(k), side, choice)
                if key not in cache:
                    cache[key] = self._moved(h, side, choice, points, C, n, dt_s)
                new_means[side], new_P[side], unseen[side] = cache[key]
            twin = next(
                (g for g in grown if np.abs(g.means - new_means).max() < 0.03), None
            )
            if twin is not None:
                continue
            grown.append(
                Hypothesis(
                    float(base[k, r, left]),
                    float(before_evidence[k] + sleeve[r, left]),
                    new_means,
                    new_P,
                    unseen,
                )
            )
            if len(grown) == p.hypotheses:
                break
        low = min(h.cost for h in grown)
        lowest = min(h.evidence for h in grown)
        chosen = np.unravel_index(best[0], total.shape)[1:]
        area = _remembered_area(state.hand_area_m2, found, [int(c) for c in chosen], p)
        return tuple(
            replace(h, cost=h.cost - low, evidence=h.evidence - lowest) for h in grown
        ), area

    def _moved(
        self, h: Hypothesis, side: int, choice: int, points: Floats, C: Floats, n: int, dt_s: float
    ) -> tuple[Floats, Floats, float]:
        m = self.parameters.motion
        if choice > n:  # not seen
            P = h.covariances[side] + spread(dt_s, m.weights, m.deviations_m) * 0.5
            return h.means[side], np.minimum(P, 0.25), float(h.unseen_s[side] + dt_s)
        mean, P, _ = correct(
            h.means[side],
            h.covariances[side],
            points[choice],
            C[choice],
            dt_s,
            m.weights,
            m.deviations_m,
        )
        return mean, P, 0.0

    def _state(
        self,
        head: HeadTrack,
        found: tuple[Hypothesis, ...],
        before: HypothesisState | None,
        dt_s: float,
        hand_area_m2: float,
        longest_m: float,
    ) -> HypothesisState:
        p = self.parameters
        totals = np.array([h.total for h in found])
        best = found[int(totals.argmin())]
        weight = np.exp(-(totals - totals.min()))
        near = totals <= totals.min() + p.mean_within
        share = np.where(near, weight, 0.0)
        share /= share.sum()
        all_means = np.array([h.means for h in found])
        hands = np.einsum("k,kij->ij", share, all_means)
        off = all_means - hands
        P = np.einsum("k,kisj->kisj", share, np.array([h.covariances for h in found])).sum(axis=0)
        P = P + np.einsum("k,kis,kij->isj", share, off, off)
        same = np.linalg.norm(all_means - best.means, axis=2).sum(axis=1)
        other = np.linalg.norm(all_means - best.means[::-1], axis=2).sum(axis=1)
        whole = weight / weight.sum()
        exchanged = float(whole[other < same].sum())
        axes = self.views.axes
        positions = np.concatenate(
            [
                head.centre(axes, p)[None],
                hands + np.array(p.hand_offset_m) @ axes,
            ]
        )
        covariances = np.concatenate([head.covariance[None], P])
        unseen = [head.unseen_s, *best.unseen_s.tolist()]
        status = tuple(
            "tracked" if u == 0 else "coasting" if u < p.lost_after_s else "lost" for u in unseen
        )
        velocities = np.zeros((3, 3))
        if before is not None and dt_s > 0:
            velocities = (positions - before.said.positions_m) / dt_s
        said = Estimates(positions, covariances, velocities, status)
        return HypothesisState(head, found, said, hand_area_m2, longest_m, exchanged)


def _remembered_area(
    area_m2: float, found: Pairs, chosen: list[int], p: HypothesisParameters
) -> float:
    """The area of a whole hand, learnt where both hands are seen apart."""
    if max(chosen) >= len(found) or not (found.part[chosen] == WHOLE).all():
        return area_m2
    if (found.blob[chosen[0]] == found.blob[chosen[1]]).any():
        return area_m2
    low, high = 0.6 * p.costs.hand_area_m2, 1.6 * p.costs.hand_area_m2
    now = np.clip(found.areas_m2[chosen], low, high).max()
    return float(area_m2 * (now / area_m2) ** p.costs.area_memory)


def _area_cost(found: Pairs, hand_area_m2: float, p: HypothesisParameters) -> Floats:
    c = p.costs
    z = np.log(np.maximum(found.areas_m2, 1e-6) / hand_area_m2)
    z = z / np.where(z > 0, c.log_area_up_sd, c.log_area_sd)
    cost = np.minimum(0.5 * z * z, 6.0)
    half = ((found.part == HALF) | (found.part == HALF + 1)).any(axis=1)
    end = (found.part >= END).any(axis=1)
    cost = np.where(end, c.end, cost)
    return cost + np.where(half, c.split, 0.0) * 0.5


def _joint_cost(
    found: Pairs,
    seen: tuple[BlobDetections, ...],
    places: tuple[Head | None, ...],
    hand_area_m2: float,
    p: HypothesisParameters,
) -> Floats:
    """Cost (n + 2, n + 2) of right and left choices together."""
    n, c = len(found), p.costs
    joint = np.zeros((n + 2, n + 2))
    joint[n, n] = 0.0
    if n == 0:
        return joint
    for view in range(2):
        b, part = found.blob[:, view], found.part[:, view]
        known = b >= 0
        same = (b[:, None] == b[None, :]) & known[:, None] & known[None, :]
        same_part = same & (part[:, None] == part[None, :])
        whole = (part == WHOLE)[:, None] | (part == WHOLE)[None, :]
        joint[:n, :n] += np.where(same_part, 0.5 * c.same_blob + 1.0, 0.0)
        joint[:n, :n] += np.where(same & ~same_part & whole, 0.5 * c.same_blob, 0.0)
        ends = (part >= END)[:, None] & (part >= END)[None, :]
        joint[:n, :n] += np.where(same & ~same_part & ends, c.same_blob, 0.0)
        half = (part == HALF) | (part == HALF + 1)
        lone = half[:, None] & ~same
        joint[:n, :n] += 0.5 * c.lone_half * (lone.astype(float) + lone.T.astype(float)) 
        joint[:n, n:] += 0.5 * c.lone_half * half[:, None]
        joint[n:, :n] += 0.5 * c.lone_half * half[None, :]
    # Hand-like blobs that nobody uses.
    plain = (found.part == WHOLE).all(axis=1) & (_area_cost(found, hand_area_m2, p) < 2.0) & (found.cost < 3.0)
    for left, right in {(int(a), int(b)) for a, b in found.blob[plain]}:
        taken = (places[0] is not None and places[0].blob == left) or (
            places[1] is not None and places[1].blob == right
        )
        if taken:
            continue
        uses = np.concatenate(
            [(found.blob[:, 0] == left) | (found.blob[:, 1] == right), [False, False]]
        )
        joint += np.where(~(uses[:, None] | uses[None, :]), c.unexplained, 0.0)
    beside = (found.part == BESIDE).all(axis=1)
    for left, right in {(int(a), int(b)) for a, b in found.blob[beside]}:
        uses = np.concatenate(
            [(found.blob[:, 0] == left) | (found.blob[:, 1] == right), [True, False]]
        )
        joint += np.where(~(uses[:, None] | uses[None, :]), 0.5 * c.unexplained, 0.0)
    return joint
