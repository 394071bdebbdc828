"""Fingers of two hands in one blob: which way each half's thin parts point.

Hands that roll round each other, cross or meet point opposite ways, and where one hides most of the
other the fingers that are left in sight still do.
"""

from __future__ import annotations

import cv2
import numpy as np

from pjpdaf.arrays import Floats
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

    hand_area_m2: of a whole hand. Of blobs that are candidates as a whole too: no pieces of the
    head's.
    """
    fingers = np.zeros((2, len(pairs), 2))
    pixels, depth = views.project(pairs.points_m)
    for v, view in enumerate(seen):
        blob, part = pairs.blob[:, v], pairs.part[:, v]
        for b in np.unique(blob[part == WHOLE]):
            halves = [np.flatnonzero((blob == b) & (part == k)) for k in (HALF, OTHER_HALF)]
            if not all(len(of) for of in halves):
                continue
            first = [int(of[0]) for of in halves]
            metre_px = float(views.focal_px[v] / depth[v, first].mean())
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
    nearer = ((pixels[:, None] - centres_px) ** 2).sum(axis=2).argmin(axis=1)
    disc = _disc(thin_px / step_px)
    for half in range(2):
        of = pixels[nearer == half]
        if len(of) < LEAST:
            continue
        cells = np.rint((of - of.min(axis=0)) / step_px).astype(np.intp) + 1
        width, height = cells.max(axis=0) + 2
        mask = np.zeros((height, width), np.uint8)
        mask[cells[:, 1], cells[:, 0]] = 1
        thick = cv2.morphologyEx(mask, cv2.MORPH_OPEN, disc)[cells[:, 1], cells[:, 0]] > 0
        middle = of[thick].mean(axis=0) if thick.any() else of.mean(axis=0)
        fingers[half] = (of[~thick] - middle).sum(axis=0) * step_px**2 / hand_px**1.5
    return fingers


def _disc(radius: float) -> np.ndarray:
    """A disc of a radius in cells, uint8."""
    reach = int(np.ceil(radius))
    y, x = np.mgrid[-reach : reach + 1, -reach : reach + 1]
    return np.asarray(x * x + y * y <= radius * radius + 0.5).astype(np.uint8)
