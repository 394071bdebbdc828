"""Fingers of two hands in one blob: which way each half's thin parts point.

Hands that roll round each other, cross or meet point opposite ways, and where one hides most of the
other the fingers that are left in sight still do.
"""

from __future__ import annotations

from functools import lru_cache

import cv2
import numpy as np

from pjpdaf.arrays import Floats, mean_point
from pjpdaf.tracker.hypotheses.blobs import Blobs
from pjpdaf.tracker.hypotheses.candidates import HALF, OTHER_HALF, WHOLE
from pjpdaf.tracker.hypotheses.geometry import Views
from pjpdaf.tracker.hypotheses.pairs import Pairs
from pjpdaf.tracker.hypotheses.parameters import SleeveParameters

LEAST = 12  # lattice pixels of a half


def fingers_of_halves(
    pairs: Pairs, seen: tuple[Blobs, ...], views: Views, hand_area_m2: float, s: SleeveParameters
) -> Floats:
    """Which way the fingers of pairs that are halves point in each view, (2, n, 2), 0 of others.

    hand_area_m2: of a whole hand, below which no blob is two. Of blobs that are candidates as a
    whole too: no pieces of the head's.
    """
    fingers = np.zeros((2, len(pairs), 2))
    pixels, depth = views.project(pairs.points_m)
    for v, view in enumerate(seen):
        blob, part = pairs.blob[:, v], pairs.part[:, v]
        for b in sorted(set(blob[part == WHOLE].tolist())):
            halves = [np.flatnonzero((blob == b) & (part == k)) for k in (HALF, OTHER_HALF)]
            if not all(len(of) for of in halves):
                continue
            first = [int(of[0]) for of in halves]
            metre_px = float(views.focal_px[v] / depth[v, first].mean())
            if view.areas_px[b] < hand_area_m2 * metre_px**2:
                continue
            found = half_fingers(
                view.looks.pixels[b],
                view.looks.pixel_area_px**0.5,
                pixels[v, first],
                hand_area_m2 * metre_px**2,
                s.thin_m * metre_px,
            )
            for of, way in zip(halves, found, strict=True):
                fingers[v, of] = s.half_fingers * way
    return fingers


def half_fingers(
    pixels: Floats,
    step_px: float,
    centres_px: Floats,
    hand_px: float,
    thin_px: float,
) -> Floats:
    """Fingers (2, 2) of the halves round centres_px (2, 2) of a blob's lattice pixels (n, 2).

    Each pixel belongs to the nearer centre. Thin is what an opening by a disc of radius thin_px
    takes away from a half: its vector from the middle of the rest, as a share of the whole hand's
    area hand_px and over its root, as `BlobLooks.fingers`. 0 where a half is too small to tell.
    """
    fingers = np.zeros((2, 2))
    low = pixels.min(axis=0)
    column, row = np.rint((pixels - low) / step_px + 1).astype(np.intp).T  # a rim all round
    way = centres_px[1] - centres_px[0]
    second = (pixels - centres_px.mean(axis=0)) @ way > 0
    grid = np.zeros((row.max() + 2, column.max() + 2), np.uint8)
    disc = _disc(round(thin_px / step_px, 1))
    for half, of in enumerate((~second, second)):
        if np.count_nonzero(of) < LEAST:
            continue
        grid[row, column] = of
        thick = cv2.morphologyEx(grid, cv2.MORPH_OPEN, disc)[row, column] > 0
        middle = mean_point(pixels[thick if thick.any() else of])
        fingers[half] = (pixels[of & ~thick] - middle).sum(axis=0) * step_px**2 / hand_px**1.5
    return fingers


@lru_cache(maxsize=64)
def _disc(radius: float) -> np.ndarray:
    """A disc of a radius in cells, uint8; not to be written to."""
    reach = int(np.ceil(radius))
    y, x = np.mgrid[-reach : reach + 1, -reach : reach + 1]
    return np.asarray(x * x + y * y <= radius * radius + 0.5).astype(np.uint8)
