"""Bare arms whose hands show no depth of their own: at the head, and where two arms meet."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.tracker.hypotheses.candidates import BESIDE, HALF, OTHER_HALF, Candidates
from pjpdaf.tracker.hypotheses.geometry import Views
from pjpdaf.tracker.hypotheses.pairs import Pairs

MET_SD_M = 0.2  # of the depth where two arms meet
BEFORE_FACE_M = 0.11
DEPTH_SD_M = 0.06


def before_face(
    pairs: Pairs, candidates: tuple[Candidates, Candidates], head_m: Floats, views: Views
) -> Pairs:
    """Pairs with no end of an arm at the head farther away than just before the face, head_m (3,).

    The line between arm and head moves with the head from view to view, and says nothing of the
    depth of the arm. Pieces that are arms have no outline of their own.
    """
    of_arms = [
        np.array(
            [part == BESIDE and own is None for part, own in zip(c.part, c.pixels, strict=True)]
        )
        for c in candidates
    ]
    seen = pairs.candidate >= 0
    ends = seen.all(axis=1)
    for view, arms in enumerate(of_arms):
        if len(arms):
            ends &= arms[pairs.candidate[:, view]]
    middle = views.centres_m.mean(axis=0)
    wanted = float((head_m - middle) @ views.axes[2]) - BEFORE_FACE_M
    ends &= (pairs.points_m - middle) @ views.axes[2] > wanted
    if not ends.any():
        return pairs
    rays = pairs.points_m[ends] - middle
    points, covariances = pairs.points_m.copy(), pairs.covariances_m2.copy()
    points[ends] = middle + rays * (wanted / np.maximum(rays @ views.axes[2], 1e-3))[:, None]
    unit = rays / np.linalg.norm(rays, axis=1, keepdims=True)
    information = np.linalg.inv(covariances[ends])
    information += unit[:, :, None] * unit[:, None, :] / DEPTH_SD_M**2
    covariances[ends] = np.linalg.inv(information)
    return replace(pairs, points_m=points, covariances_m2=covariances)


def unsure_depth(pairs: Pairs, candidates: tuple[Candidates, Candidates], views: Views) -> Pairs:
    """Pairs with little known of the depth of hands where two bare arms meet.

    Their places come from the ends of the arms, the elbows, which are farther away.
    """
    of_arms = [
        np.array(
            [
                part in (HALF, OTHER_HALF) and own is not None
                for part, own in zip(c.part, c.pixels, strict=True)
            ],
            np.bool_,
        )
        for c in candidates
    ]
    met = (pairs.candidate >= 0).all(axis=1)
    for view, arms in enumerate(of_arms):
        if len(arms):
            met &= arms[pairs.candidate[:, view]]
    rays = pairs.points_m[met] - views.centres_m.mean(axis=0)
    unit = rays / np.linalg.norm(rays, axis=1, keepdims=True)
    covariances = pairs.covariances_m2.copy()
    covariances[met] += unit[:, :, None] * unit[:, None, :] * MET_SD_M**2
    return replace(pairs, covariances_m2=covariances)
