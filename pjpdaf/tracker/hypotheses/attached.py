"""Blobs that hang on the person: a hand has an arm, which leads to the head through the silhouette.

What a chair, a box or the place of a cup that was taken away shows of the colour of skin stands
apart, and may stay there for ever.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Floats
from pjpdaf.tracker.hypotheses.blobs import Blobs
from pjpdaf.tracker.hypotheses.geometry import Views
from pjpdaf.tracker.hypotheses.memory import kept_share
from pjpdaf.tracker.hypotheses.pairs import Pairs

GAP_M = 0.02  # that the silhouette may have between hand and head
HEAD_M = 0.08  # from the head's centre: what is foreground there is the head
SPARSE = 16  # every so many pixels are looked at first
MEMORY_S = 3.2  # of the mean that says whether this person's hands hang on it


def attached(seen: tuple[Blobs, ...], head_m: Floats, views: Views) -> list[NDArray[np.bool_]]:
    """Whether each blob (n,) of each view hangs on the head, head_m (3,), by way of foreground.

    Where a view has no silhouette, or none at the head, all do.
    """
    pixels, depth = views.project(head_m)
    found = []
    for v, view in enumerate(seen):
        hangs = np.ones(len(view), np.bool_)
        found.append(hangs)
        shape = view.looks.silhouette
        if shape is None or not len(view):
            continue
        metre = float(views.focal_px[v] / depth[v]) / shape.step_px
        size = 2 * max(round(0.5 * GAP_M * metre), 1) + 1
        mask = cv2.dilate((shape.classes > 0).astype(np.uint8), np.ones((size, size), np.uint8))
        count, labels = cv2.connectedComponents(mask, connectivity=8, ltype=cv2.CV_16U)
        at_head = labels[_cells(pixels[v][None], shape.step_px, labels.shape)]
        x, y = (pixels[v] + 0.5) / shape.step_px - 0.5
        reach = max(HEAD_M * metre, 1.0)
        near = labels[
            max(int(y - reach), 0) : max(int(y + reach) + 1, 0),
            max(int(x - reach), 0) : max(int(x + reach) + 1, 0),
        ]
        person = np.zeros(count, np.bool_)
        person[near], person[at_head] = True, True
        person[0] = False  # the background
        if not person.any():
            continue
        for i, of_blob in enumerate(view.looks.pixels):
            # Most blobs show it in a few of their pixels.
            hangs[i] = any(
                person[labels[_cells(some, shape.step_px, labels.shape)]].any()
                for some in (of_blob[::SPARSE], of_blob)
            )
    return found


def apart_cost(pairs: Pairs, hangs: list[NDArray[np.bool_]], share: float, cost: float) -> Floats:
    """Cost (n,) of pairs that hang on the person in no view that shows them.

    share: of this person's hands that hang on them, as learnt; a half or less says nothing.
    """
    none: NDArray[np.bool_] = np.ones(len(pairs), np.bool_)
    for v, of_blob in enumerate(hangs):
        shown = pairs.blob[:, v] >= 0
        none[shown] &= ~of_blob[pairs.blob[shown, v]]
    return np.asarray(np.where(none, cost * max(2.0 * share - 1.0, 0.0), 0.0))


def learnt_share(
    share: float,
    pairs: Pairs,
    chosen: tuple[int, int],
    hangs: list[NDArray[np.bool_]],
    dt_s: float,
) -> float:
    """The share of hands that hang on the person, after those chosen in a frame dt_s later."""
    of = [k for k in chosen if k < len(pairs)]
    if not of:
        return share
    now = float((apart_cost(pairs[np.array(of)], hangs, 1.0, 1.0) == 0).mean())
    return share + (1.0 - kept_share(dt_s, MEMORY_S)) * (now - share)


def _cells(
    pixels: Floats, step_px: int, size: tuple[int, ...]
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Rows and columns in the reduced picture of pixels (n, 2)."""
    at = np.rint((pixels + 0.5) / step_px - 0.5).astype(np.intp)
    return at[:, 1].clip(0, size[0] - 1), at[:, 0].clip(0, size[1] - 1)
