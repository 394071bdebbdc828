"""Hands that the picture's edge cuts: both views' places from the side that both show."""

from __future__ import annotations

import numpy as np

from pjpdaf.arrays import Floats, Ints
from pjpdaf.tracker.hypotheses.blobs import Blobs
from pjpdaf.tracker.hypotheses.geometry import Views

WIDTH_PX = 640.0  # at scale 1
MARGIN = 1.5  # steps of the lattice from the picture's edge, of a blob that it cuts
LEAST_ROWS = 4  # that both views show


def cut_sides(view: Blobs, views: Views) -> Ints:
    """Which side edge of the picture cuts each blob (n,): -1 left, 1 right, 0 none.

    A blob that reaches both edges is no hand: 0.
    """
    margin = MARGIN * view.looks.pixel_area_px**0.5
    sides = np.zeros(len(view), np.intp)
    for i, pixels in enumerate(view.looks.pixels):
        if len(pixels):
            x = pixels[:, 0]
            sides[i] = int(x.max() > views.scale * WIDTH_PX - 1 - margin) - int(x.min() < margin)
    return sides


def agreed_centres(
    views: Views, seen: tuple[Blobs, ...], blobs: tuple[int, int], side: int
) -> tuple[Floats, Floats] | None:
    """Centres (2,) [px] in both views of one thing whose part beyond an edge one of them lacks.

    blobs: of the views; side: of the edge, -1 left, 1 right. The centroid of a cut blob has moved
    away from the edge, and the depth with it. The side that the edge leaves alone has not: its mean
    distance along the rows between the views is the disparity. The larger blob gives the centre.
    None where too few rows are common.
    """
    one, two = (view.looks.pixels[blob] for view, blob in zip(seen, blobs, strict=True))
    whole = 0 if seen[0].areas_px[blobs[0]] >= seen[1].areas_px[blobs[1]] else 1
    other = 1 - whole
    centre = seen[whole].centres_px[blobs[whole]]
    step = max(view.looks.pixel_area_px**0.5 for view in seen)
    # The epipolar line of the centre: other_y as a function of other_x.
    ray = views.rays(whole, centre[None])[0]
    near, far = (views.project(views.centres_m[whole] + z * ray)[0][other] for z in (0.8, 1.6))
    slope = (far[1] - near[1]) / (far[0] - near[0]) if abs(far[0] - near[0]) > 1e-6 else 0.0
    lower = near[1] + slope * (seen[other].centres_px[blobs[other], 0] - near[0]) - centre[1]
    inner = _inner_sides((one, two)[whole], step, side)
    paired = _inner_sides((one, two)[other] - np.array([0.0, lower]), step, side)
    common = inner.keys() & paired.keys()
    if len(common) < LEAST_ROWS:
        return None
    x = float(centre[0]) - float(np.mean([inner[row] - paired[row] for row in common]))
    moved = np.array([x, near[1] + slope * (x - near[0])])
    return (centre, moved) if whole == 0 else (moved, centre)


def _inner_sides(pixels: Floats, step: float, side: int) -> dict[int, float]:
    """The blob's end away from the edge in each of its rows."""
    rows = np.rint(pixels[:, 1] / step).astype(int)
    low = rows.min()
    ends = np.full(rows.max() - low + 1, np.inf)
    np.minimum.at(ends, rows - low, side * pixels[:, 0])
    return {int(low + k): side * float(x) for k, x in enumerate(ends) if np.isfinite(x)}
