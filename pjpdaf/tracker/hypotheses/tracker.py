"""Hypothesis tracker: head, right hand and left hand over joint configurations."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import final

import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.camera import Camera
from pjpdaf.interfaces import Detections, Estimates
from pjpdaf.known_targets import KnownTargets
from pjpdaf.tracker.hypotheses.arm_at_head import before_face, unsure_depth
from pjpdaf.tracker.hypotheses.attached import apart_cost, attached, learnt_share
from pjpdaf.tracker.hypotheses.blobs import Blobs
from pjpdaf.tracker.hypotheses.candidates import WHOLE, HeadPlace, candidates
from pjpdaf.tracker.hypotheses.centres import outward
from pjpdaf.tracker.hypotheses.costs import (
    area_cost,
    end_cost,
    joint_cost,
    likeliest,
    piece_cost,
    side_evidence,
)
from pjpdaf.tracker.hypotheses.early import Early, early_sightings
from pjpdaf.tracker.hypotheses.geometry import Views
from pjpdaf.tracker.hypotheses.head import HeadTrack, follow_head
from pjpdaf.tracker.hypotheses.head_pieces import join_head
from pjpdaf.tracker.hypotheses.hypothesis import (
    FORBIDDEN,
    Hypothesis,
    Sightings,
    grow,
    nearest_choices,
)
from pjpdaf.tracker.hypotheses.identity import either, halves_doubt, hidden_doubt
from pjpdaf.tracker.hypotheses.lag import Past, look_back
from pjpdaf.tracker.hypotheses.memory import kept_share
from pjpdaf.tracker.hypotheses.missing_hand import hand_missing
from pjpdaf.tracker.hypotheses.motion import spread
from pjpdaf.tracker.hypotheses.opening import open_tracks
from pjpdaf.tracker.hypotheses.pairs import Pairs, pair_candidates
from pjpdaf.tracker.hypotheses.parameters import HypothesisParameters
from pjpdaf.tracker.hypotheses.readout import read_out
from pjpdaf.tracker.hypotheses.skew import NOISE_PX, Skew, Skewed, shifts
from pjpdaf.tracker.hypotheses.stereo_split import halve_together

VIEWS = 2
START_SD_M = 0.02
HANDS_BEFORE_HEAD_M = 0.15  # along the line of sight, for the size of a hand in pixels
BEHIND_M, BEFORE_M = 0.3, 0.9  # the head: where hands can be
APART_M = 0.3  # hands whose arms are looked at
NEAR_HAND_M = 0.15  # from a hand to the centre of its arm's blob
LONGEST_M = 0.45
LONGER_S, SHORTER_S = 4.0, 20.0  # memory of an arm's length: pointing at a camera shortens it
FACE_PLACES = (0, 0), (-1, 0), (1, 0), (-1, 1), (1, 1), (0, 1)  # right, down
BEHIND_HEAD_M, ABOVE_M = 0.14, 0.04  # a hand behind the head
BEFORE_FACE_M, BELOW_FACE_M = 0.06, 0.02  # a hand at the face


@dataclass(frozen=True, eq=False)
class HypothesisState:
    """All that changes from frame to frame.

    hypotheses: from the likeliest; estimates: the latest; hand_area_m2: of a whole hand, learnt;
    longest_m: mean length of the longer hand's blob, which tells bare forearms; dt_s: time since
    the state before; doubt: that the hands changed places while both were hidden; skew: of the
    views' moments, None where it is not learnt; hanging: share of the hands' blobs that hang on the
    person, learnt.
    """

    head: HeadTrack
    hypotheses: tuple[Hypothesis, ...]
    estimates: Estimates
    hand_area_m2: float
    longest_m: float
    dt_s: float = 0.0
    doubt: float = 0.0
    skew: Skew | None = None
    hanging: float = 1.0


@final
class HypothesisTracker:
    """Tracker of head and hands in two calibrated views; all that changes is in the state."""

    def __init__(
        self, cameras: tuple[Camera, ...], parameters: HypothesisParameters | None = None
    ) -> None:
        if len(cameras) != VIEWS:
            raise ValueError(f"the hypothesis tracker needs {VIEWS} cameras, got {len(cameras)}")
        self.cameras = tuple(cameras)
        self.parameters = parameters if parameters is not None else HypothesisParameters()
        self.views = Views.of(self.cameras)

    def start(self, detections: tuple[Detections, ...], /) -> HypothesisState | Early | None:
        """Return the first state, or None where nothing is clear yet: wait.

        `Early` is the state while head and hands are not seen apart yet.
        """
        p = self.parameters
        seen = tuple(Blobs.of(view) for view in detections)
        opened = open_tracks(seen, self.views, p)
        if opened is None:
            return early_sightings(seen, self.views, p) if p.early else None
        P = np.tile(np.eye(3) * START_SD_M**2, (2, 1, 1))
        hypotheses = tuple(
            Hypothesis(0.0, cost, hands, P, np.zeros(2)) for hands, cost in opened.hands
        )
        estimates = read_out(opened.head, hypotheses, None, self.views, 0.0, p)
        area = p.costs.hand_area_m2
        skew = Skew(NOISE_PX * self.views.scale) if p.noise.learn_skew else None
        return HypothesisState(
            opened.head, hypotheses, estimates, area, opened.longest_m, skew=skew
        )

    def estimates(self, state: HypothesisState | Early, /) -> Estimates:
        """Return the estimates of a state."""
        return state.estimates

    def predict(self, state: HypothesisState | Early, dt_s: float, /) -> Estimates:
        """Return the estimates expected dt_s after `state`: the same places, less certain.

        Nothing is expected before the start.
        """
        if isinstance(state, Early):
            return Estimates.waiting()
        m = self.parameters.motion
        head = spread(dt_s, m.head_weights, m.head_deviations_m)
        hand = spread(dt_s, m.weights, m.deviations_m)
        grown = state.estimates.covariances_m2 + np.array([head, hand, hand])
        return replace(state.estimates, covariances_m2=grown)

    def step(
        self, state: HypothesisState | Early, detections: tuple[Detections, ...], dt_s: float, /
    ) -> tuple[HypothesisState | Early, Estimates]:
        """Return the state and the estimates after the next frame, dt_s later."""
        if isinstance(state, Early):
            return self._early(detections)
        return self._step(state, detections, dt_s, None)

    def step_associated(
        self,
        state: HypothesisState | Early,
        detections: tuple[Detections, ...],
        known: KnownTargets,
        dt_s: float,
        /,
    ) -> tuple[HypothesisState | Early, Estimates]:
        """Step with the blob of the head and the choices of the hands that are nearest to known."""
        if isinstance(state, Early):
            return self._early(detections)
        return self._step(state, detections, dt_s, self._surfaces(state, known))

    def expecting(
        self, state: HypothesisState | Early, known: KnownTargets, dt_s: float, /
    ) -> HypothesisState | Early:
        """Return the state with the likeliest hypothesis alone, moved to the known targets."""
        if isinstance(state, Early):
            return state
        surfaces = self._surfaces(state, known)
        hands = replace(state.hypotheses[0], means=surfaces[1:])
        return replace(state, head=replace(state.head, mean=surfaces[0]), hypotheses=(hands,))

    def _early(
        self, detections: tuple[Detections, ...]
    ) -> tuple[HypothesisState | Early, Estimates]:
        """A frame before the start, or the start."""
        state = self.start(detections) or Early(Estimates.waiting())
        return state, state.estimates

    def _surfaces(self, state: HypothesisState, known: KnownTargets) -> Floats:
        """Where the tracker sees known targets (3, 3) [m]: centres less the modelled offsets."""
        p, axes = self.parameters, self.views.axes
        head = state.head.centre(axes, p) - state.head.mean
        hand = np.array(p.offsets.hand_offset_m) @ axes
        return np.asarray(known.positions_m - np.array([head, hand, hand]))

    def _step(
        self,
        state: HypothesisState,
        detections: tuple[Detections, ...],
        dt_s: float,
        known_m: Floats | None,
    ) -> tuple[HypothesisState, Estimates]:
        """Step; known_m (3, 3) [m]: visible surfaces to be chosen, None: what is likeliest."""
        p = self.parameters
        seen = tuple(Blobs.of(view) for view in detections)
        if p.candidates.join_head:
            seen = join_head(state.head, seen, self.views)
        head_m = None if known_m is None else known_m[0]
        joined = self._joined(state, seen)
        head, places = follow_head(state.head, seen, self.views, dt_s, p, head_m, joined)
        hangs = attached(seen, head.mean, self.views) if p.costs.apart > 0 else None
        pairs = self._pairs(state, seen, places, head, dt_s)
        if hangs is not None:
            extra = apart_cost(pairs, hangs, state.hanging, p.costs.apart)
            pairs = replace(pairs, cost=pairs.cost + extra)
        face_m, face_cost = self._at_head(head, places)
        sightings = Sightings(
            pairs,
            pairs.cost + area_cost(pairs, state.hand_area_m2, p.costs),
            joint_cost(pairs, places, state.hand_area_m2, p.costs),
            side_evidence(
                pairs, seen, head.mean, self.views, p, state.hand_area_m2, self._bare(state)
            ),
            face_m,
            face_cost,
            outward(pairs.part, seen, self.views.axes, p.offsets),
        )
        only = None
        if known_m is not None:
            only = nearest_choices(sightings, known_m[1:], state.hypotheses[0].means)
        grown, chosen = grow(state.hypotheses, sightings, dt_s, p, only)
        side = _side_of(sightings, chosen)
        doubt = hidden_doubt(state.doubt, grown[0], side, dt_s, p.identity)
        stated = either(doubt, halves_doubt(grown, dt_s, p))
        estimates = read_out(head, grown, state.estimates, self.views, dt_s, p, stated)
        hanging = state.hanging
        if hangs is not None:
            hanging = learnt_share(hanging, pairs, chosen, hangs, dt_s)
        after = HypothesisState(
            head,
            grown,
            estimates,
            _learnt_area(state.hand_area_m2, pairs, list(chosen), p),
            self._longest(state, seen, places, dt_s),
            dt_s,
            doubt,
            self._learnt_skew(state, pairs, chosen, seen, dt_s),
            hanging,
        )
        return after, estimates

    def _learnt_skew(
        self,
        state: HypothesisState,
        pairs: Pairs,
        chosen: tuple[int, int],
        seen: tuple[Blobs, ...],
        dt_s: float,
    ) -> Skew | None:
        """The skew with what whole hands show of it that both views see."""
        of = [k for k in chosen if k < len(pairs) and (pairs.part[k] == WHOLE).all()]
        if state.skew is None or not of or dt_s <= 0:
            return state.skew
        left, right = (seen[v].centres_px[pairs.blob[of, v]] for v in range(VIEWS))
        s = shifts(self.views, left, right, state.hypotheses[0].means, dt_s)
        return state.skew.after(s.r_px, s.across, dt_s)

    def _joined(self, state: HypothesisState, seen: tuple[Blobs, ...]) -> tuple[bool, ...]:
        """Whether each view's blob of the head must show a hand too."""
        if not self.parameters.candidates.missing_hand:
            return (False, False)
        _, depth = self.views.project(state.head.mean)
        area_px = state.hand_area_m2 * (self.views.focal_px / depth) ** 2
        hands = state.hypotheses[0].means
        return tuple(
            hand_missing(view, state.head.mean, hands, float(area_px[v]))
            for v, view in enumerate(seen)
        )

    def _at_head(
        self, head: HeadTrack, places: tuple[HeadPlace | None, ...]
    ) -> tuple[Floats, Floats]:
        """Places (f, 3) [m] of a hand that the head's blob hides, and their costs (f,).

        Before the face while the blob is larger than the head; behind the head, which shows in
        nothing but that the hand is gone.
        """
        c, reach = self.parameters.costs, self.parameters.noise.face_reach_m
        axes = self.views.axes
        larger = any(place is not None and not place.free for place in places)
        before = c.face if larger or head.unseen_s > 0 else FORBIDDEN
        alone = all(place is not None and (place.free or place.as_free) for place in places)
        behind = c.behind if c.behind > 0 and alone else FORBIDDEN
        centre = head.mean - BEFORE_FACE_M * axes[2] + BELOW_FACE_M * axes[1]
        face = centre + reach * np.array(FACE_PLACES[: 1 if reach == 0 else None]) @ axes[:2]
        back = head.mean + BEHIND_HEAD_M * axes[2] - ABOVE_M * axes[1]
        costs = np.array([*[before] * len(face), behind])
        return np.concatenate([face, back[None]]), costs

    def smoothed(self, states: tuple[HypothesisState | Early, ...], /) -> Estimates:
        """Return the estimates of the first state in the knowledge of the later ones."""
        first = states[0]
        if isinstance(first, Early):
            return first.estimates
        past = [Past(s.head, s.hypotheses, s.dt_s) for s in states if not isinstance(s, Early)]
        stated = either(first.doubt, halves_doubt(first.hypotheses, first.dt_s, self.parameters))
        return look_back(past, first.estimates, self.views, self.parameters, stated)

    def _pairs(
        self,
        state: HypothesisState,
        seen: tuple[Blobs, ...],
        places: tuple[HeadPlace | None, ...],
        head: HeadTrack,
        dt_s: float,
    ) -> Pairs:
        """All sightings of hands before the person, with the costs of their looks."""
        p = self.parameters
        bare = self._bare(state)
        area_m2 = state.hand_area_m2
        _, depth = self.views.project(head.mean)
        metre_px = self.views.focal_px / np.maximum(depth - HANDS_BEFORE_HEAD_M, 0.3)
        # A head that is out of sight still hides no blob: -1 is no blob's number.
        nowhere = HeadPlace(-1, True, np.zeros(2), np.eye(2))
        together = p.candidates.halve_together
        one, two = (
            candidates(
                view,
                place or nowhere,
                float(metre_px[v]),
                area_m2,
                bare,
                p.candidates,
                cut=not together,
            )
            for v, (view, place) in enumerate(zip(seen, places, strict=True))
        )
        if together:
            hand_px = area_m2 * metre_px**2
            at = float(hand_px[0]), float(hand_px[1])
            one, two = halve_together(self.views, seen, (one, two), at, p.candidates)
        expected = np.concatenate([h.means for h in state.hypotheses])
        skewed = None
        if state.skew is not None and dt_s > 0:
            skewed = Skewed(state.skew, state.hypotheses[0].means, dt_s)
        pairs = pair_candidates(self.views, (one, two), expected, p.noise, p.costs, seen, skewed)
        if bare:
            pairs = before_face(pairs, (one, two), head.mean, self.views)
            pairs = unsure_depth(pairs, (one, two), self.views)
        away = (pairs.points_m - head.mean) @ self.views.axes[2]
        pairs = pairs[(away < BEHIND_M) & (away > -BEFORE_M)]
        extra = piece_cost(pairs, head.mean, self.views.axes, p.costs)
        if bare:
            extra = extra + end_cost(pairs, self.views.axes, p.costs)
        pairs = replace(pairs, cost=pairs.cost + extra)
        return likeliest(pairs, expected, state.hand_area_m2, p.costs)

    def _bare(self, state: HypothesisState) -> bool:
        """Whether the forearms are bare."""
        return state.longest_m > self.parameters.candidates.bare_length_m

    def _longest(
        self,
        state: HypothesisState,
        seen: tuple[Blobs, ...],
        places: tuple[HeadPlace | None, ...],
        dt_s: float,
    ) -> float:
        """Mean length [m] of the longer hand's blob while the hands are apart."""
        hands = state.hypotheses[0].means
        if np.linalg.norm(hands[0] - hands[1]) < APART_M:
            return state.longest_m
        pixels, depth = self.views.project(hands)
        lengths = []
        for v, (view, place) in enumerate(zip(seen, places, strict=True)):
            for hand in range(2 if len(view) else 0):
                metre_px = float(self.views.focal_px[v] / depth[v, hand])
                distance = np.linalg.norm(view.centres_px - pixels[v, hand], axis=1)
                blob = int(distance.argmin())
                if distance[blob] < NEAR_HAND_M * metre_px and (
                    place is None or place.blob != blob
                ):
                    lengths.append(view.length_m(blob, metre_px))
        longest = max((length for length in lengths if length < LONGEST_M), default=state.longest_m)
        memory_s = LONGER_S if longest > state.longest_m else SHORTER_S
        share = 1.0 - kept_share(dt_s, memory_s)
        return state.longest_m + share * (longest - state.longest_m)


def _side_of(seen: Sightings, chosen: tuple[int, int]) -> float:
    """Log-odds that the chosen (right, left) are the right way round; 0 of an unseen hand."""
    right, left = (float(seen.odds[k]) if k < len(seen.odds) else 0.0 for k in chosen)
    return right - left


def _learnt_area(area_m2: float, pairs: Pairs, chosen: list[int], p: HypothesisParameters) -> float:
    """Area of a whole hand, learnt where both hands are seen apart."""
    if max(chosen) >= len(pairs) or not (pairs.part[chosen] == WHOLE).all():
        return area_m2
    if (pairs.blob[chosen[0]] == pairs.blob[chosen[1]]).any():
        return area_m2
    low, high = 0.6 * p.costs.hand_area_m2, 1.6 * p.costs.hand_area_m2
    now: Floats = np.clip(pairs.areas_m2[chosen], low, high)
    return float(area_m2 * (now.max() / area_m2) ** p.costs.area_memory)
