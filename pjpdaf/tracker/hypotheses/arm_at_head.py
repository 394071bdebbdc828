"""Bare arms whose hands show no depth of their own: at the head, and where two arms meet."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

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
    ends = _in_both_views(pairs, candidates, (BESIDE,), outlined=False)
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
    met = _in_both_views(pairs, candidates, (HALF, OTHER_HALF), outlined=True)
    rays = pairs.points_m[met] - views.centres_m.mean(axis=0)
    unit = rays / np.linalg.norm(rays, axis=1, keepdims=True)
    covariances = pairs.covariances_m2.copy()
    covariances[met] += unit[:, :, None] * unit[:, None, :] * MET_SD_M**2
    return replace(pairs, covariances_m2=covariances)


def _in_both_views(
    pairs: Pairs,
    candidates: tuple[Candidates, Candidates],
    parts: tuple[int, ...],
    *,
    outlined: bool,
) -> NDArray[np.bool_]:
    """Which pairs (n,) are of such parts in both views; outlined: with an outline of their own."""
    chosen: NDArray[np.bool_] = np.asarray((pairs.candidate >= 0).all(axis=1))
    for view, c in enumerate(candidates):
        if len(c.part):
            own = np.array([pixels is not None for pixels in c.pixels])
            of_parts = np.isin(c.part, parts) & (own == outlined)
            chosen &= of_parts[pairs.candidate[:, view]]
    return chosen
