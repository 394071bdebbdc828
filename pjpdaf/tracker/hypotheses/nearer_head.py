"""A head that came nearer: larger in the pictures than expected, and as large as ever in metres.

A person who leans forward by 0.2 m has a head whose blob is a third larger. Taken for a head with
something in it, its depth would hardly count, and the head be held where it was.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.tracker.hypotheses.blobs import Blobs
from pjpdaf.tracker.hypotheses.candidates import HeadPlace
from pjpdaf.tracker.hypotheses.geometry import Views

LIKE_LOG_AXIS = 0.12  # between the axes of a head that came nearer and the remembered ones


def nearer_head(
    places: Sequence[HeadPlace | None],
    seen: Sequence[Blobs],
    views: Views,
    area_m2: float,
    shape_m2: Floats,
    most_ratio: float,
    residual_px: float,
) -> tuple[HeadPlace | None, ...]:
    """The places, with whole blobs for the head where both views show one of its size.

    area_m2, shape_m2 (2, 2): area and second moments of the free head; most_ratio: of a blob's area
    to it, at the depth that the centroids of both blobs have; residual_px: the largest, of views
    that agree. Places of which one is free or not seen stay as they are.
    """
    if any(place is None or place.free for place in places):
        return tuple(places)
    blobs = [place.blob for place in places if place is not None]
    centres = [view.centres_px[blob] for view, blob in zip(seen, blobs, strict=True)]
    points, residual = views.triangulate(centres[0][None], centres[1][None])
    if residual[0] > residual_px:
        return tuple(places)
    _, depth = views.project(points[0])
    areas = np.array([view.areas_px[blob] for view, blob in zip(seen, blobs, strict=True)])
    metres = depth / views.focal_px
    axes = np.array([view.ellipses[b][2:4] for view, b in zip(seen, blobs, strict=True)])
    like = np.log(np.sort(axes * metres[:, None], axis=1) / free_axes(shape_m2))
    if (areas * metres**2 > most_ratio * area_m2).any() or np.abs(like).max() > LIKE_LOG_AXIS:
        return tuple(places)
    return tuple(
        HeadPlace(blob, True, centre, place.shape_px2)
        for blob, centre, place in zip(blobs, centres, places, strict=True)
        if place is not None
    )


def free_axes(shape_m2: Floats) -> Floats:
    """Half axes (2,) [m], the shorter first, of the ellipse with these second moments (2, 2)."""
    return np.asarray(2.0 * np.sqrt(np.maximum(np.linalg.eigvalsh(shape_m2), 1e-9)))
