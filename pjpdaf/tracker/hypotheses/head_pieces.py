"""Head in pieces: blobs that lie in the remembered head and together are as large are one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.looks import BlobLooks
from pjpdaf.tracker.hypotheses.blobs import Blobs
from pjpdaf.tracker.hypotheses.geometry import Views
from pjpdaf.tracker.hypotheses.head import HeadTrack
from pjpdaf.tracker.hypotheses.split import settle, squared_distance

WHOLE_RATIO = 0.8  # of the remembered area: a blob that is larger needs no other piece
LARGEST_RATIO = 1.15  # of all pieces together: a hand before the head makes them larger
INSIDE = 0.7  # share of a piece's pixels in the head's ellipse
REACH = 2.5  # deviations of the head's shape in which pieces are looked for


def join_head(track: HeadTrack, seen: tuple[Blobs, ...], views: Views) -> tuple[Blobs, ...]:
    """Blobs of all views with the pieces of the head as one blob, the last.

    A fringe, a frame of glasses or a beard that is no skin cuts the head in two.
    """
    pixels, depth = views.project(track.mean)
    joined = []
    for v, view in enumerate(seen):
        metre_px = float(views.focal_px[v] / depth[v])
        area, shape = track.area_m2 * metre_px**2, track.shape_m2 * metre_px**2
        joined.append(_joined(view, _pieces(view, pixels[v], shape, area)))
    return tuple(joined)


def _pieces(view: Blobs, expected: Floats, shape: Floats, area: float) -> list[int]:
    inverse = np.linalg.inv(shape)

    def inside(i: int, centre: Floats, scale: float) -> float:
        pixels = view.looks.pixels[i]
        near = squared_distance(pixels, centre, inverse) <= scale * scale
        return np.count_nonzero(near) / len(pixels)

    near = [
        i
        for i in range(len(view))
        if 0.02 * area < view.areas_px[i] < area and len(view.looks.pixels[i])
        if inside(i, expected, 2.0 * REACH) > INSIDE
    ]
    if len(near) < 2 or max(view.areas_px[i] for i in near) > WHOLE_RATIO * area:
        return []
    together = np.concatenate([view.looks.pixels[i] for i in near])
    centre, _ = settle(together, expected, shape)
    pieces = [i for i in near if inside(i, centre, 2.2) > INSIDE]
    total = sum(float(view.areas_px[i]) for i in pieces)
    return pieces if len(pieces) > 1 and total < LARGEST_RATIO * area else []


def _joined(view: Blobs, pieces: list[int]) -> Blobs:
    if not pieces:
        return view
    kept = [i for i in range(len(view)) if i not in pieces]
    largest = max(pieces, key=lambda i: float(view.areas_px[i]))
    order = [*kept, largest]
    areas = view.areas_px[pieces]
    pixels = np.concatenate([view.looks.pixels[i] for i in pieces])
    centre = (view.centres_px[pieces] * areas[:, None]).sum(axis=0) / areas.sum()
    values, vectors = np.linalg.eigh(np.cov(pixels.T))
    angle = float(np.arctan2(vectors[1, 1], vectors[0, 1]))
    axes = 2.0 * np.sqrt(np.maximum(values[::-1], 1e-6))
    looks = BlobLooks(
        (*(view.looks.pixels[i] for i in kept), pixels),
        view.looks.pixel_area_px,
        view.looks.palms[order],
        view.looks.fingers[order],
        view.looks.silhouette,
    )
    return replace(
        view,
        centres_px=np.vstack([view.centres_px[kept], centre]),
        areas_px=np.append(view.areas_px[kept], areas.sum()),
        ellipses=np.vstack([view.ellipses[kept], [*centre, *axes, angle]]),
        looks=looks,
        evidence=None if view.evidence is None else view.evidence[order],
    )
