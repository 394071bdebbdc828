"""The first positions: three blobs that both views agree on, the head above, hands apart."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations

import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.detector.blob_detector import BlobDetections
from pjpdaf.tracker.hypotheses.candidates import WHOLE, Head, blob_length_m, candidates, pairs
from pjpdaf.tracker.hypotheses.geometry import Views
from pjpdaf.tracker.hypotheses.head import CROWN_M, HeadTrack, crown_of, head_size
from pjpdaf.tracker.hypotheses.parameters import HypothesisParameters
from pjpdaf.tracker.hypotheses.sleeve import Body, arm_scores, arm_values

HEAD_AREA_M2 = 0.024  # of visible skin, with the neck
HEAD_LOG_SD = 0.4
APART_M = 0.12  # hands nearer to each other than this may be two pieces of one arm
REACH_M = 0.85  # from the head
WRONG_SIDE = 2.0  # cost of a right hand on the left of the left hand


def open_tracks(
    seen: tuple[BlobDetections, ...], views: Views, p: HypothesisParameters
) -> tuple[HeadTrack, list[tuple[Floats, float]], float] | None:
    """The head's track, places of right and left hand (2, 3) with their costs, and the length [m]
    of the longest blob that may be a hand; None: wait.
    """
    if len(seen) != 2 or any(view.missing or len(view) < 3 for view in seen):
        return None
    plain = replace(p.candidates, halves=False, beside_head=False)
    top = [int(view.centres_px[:, 1].argmin()) for view in seen]
    lengths = [
        blob_length_m(view, i, 1.2, float(views.focal_px[v]))
        for v, view in enumerate(seen)
        for i in range(len(view))
        if view.centres_px[i, 1] > view.centres_px[top[v], 1] + 0.12 / 1.2 * views.focal_px[v]
    ]
    length = max(lengths, default=0.0)
    bare = length > plain.bare_length_m
    each = tuple(
        candidates(view, None, 1.2, float(views.focal_px[v]), bare, plain)
        for v, view in enumerate(seen)
    )
    found = pairs(views, (each[0], each[1]), np.zeros((0, 3)), p.noise, p.costs)
    if len(found) < 3:
        return None
    up = -(found.points_m @ views.axes[1])
    best = None
    whole = (found.part == WHOLE).all(axis=1)
    for i in np.flatnonzero(whole):
        z = np.log(found.areas_m2[i] / HEAD_AREA_M2) / HEAD_LOG_SD
        below = (up < up[i] - 0.08).sum()
        if abs(z) > 3.0 or below < 2:
            continue
        cost = 0.5 * z * z + found.cost[i] - 4.0 * up[i]
        if best is None or cost < best[0]:
            best = (cost, int(i))
    if best is None:
        return None
    head = best[1]
    places = tuple(
        Head(int(found.blob[head, v]), True, seen[v].centres_px[found.blob[head, v]], np.eye(2))
        for v in range(2)
    )
    mean = found.points_m[head]
    area, shape = head_size(mean, seen, places, views)
    track = HeadTrack(
        mean, np.eye(3) * 0.02**2, area, shape, crown_of(mean, seen, views) or CROWN_M
    )
    body = Body.under(mean, views.axes, p.sleeve)
    values = arm_values(tuple(view.silhouette for view in seen), views, body, p.sleeve)
    step_px = [v.silhouette.step_px if v.silhouette is not None else 1 for v in seen]
    scores = arm_scores(found.points_m, values, step_px, views, body, p.sleeve)
    forward = (found.points_m - mean) @ -views.axes[2]
    good = (
        (up < up[head] - 0.05)
        & (np.linalg.norm(found.points_m - mean, axis=1) < REACH_M)
        & (forward > -0.2)
        & (found.blob != found.blob[head]).all(axis=1)
    )
    starts: list[tuple[Floats, float]] = []
    for a, b in combinations(np.flatnonzero(good), 2):
        if (found.blob[a] == found.blob[b]).any():
            continue
        distance = float(np.linalg.norm(found.points_m[a] - found.points_m[b]))
        if distance < APART_M:
            continue
        for right, left in ((a, b), (b, a)):
            gap = float((found.points_m[left] - found.points_m[right]) @ views.axes[0])
            cost = float(found.cost[right] + found.cost[left])
            for k in (right, left):
                z = np.log(found.areas_m2[k] / p.costs.hand_area_m2) / p.costs.log_area_sd
                cost += min(0.5 * z * z, 6.0) if (found.part[k] == WHOLE).all() else p.costs.end
            cost -= p.sleeve.weight * float(scores[right, 0] + scores[left, 1])
            cost += WRONG_SIDE if gap < 0 else 0.0
            starts.append((np.array([found.points_m[right], found.points_m[left]]), cost))
    if not starts:
        return None
    starts.sort(key=lambda s: s[1])
    least = starts[0][1]
    near = [(points, cost - least) for points, cost in starts[: p.hypotheses] if cost < least + 8]
    return track, near, length
