"""Hair beside the face: how much of the silhouette beside the face's skin is no skin."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Floats
from pjpdaf.looks import SKIN
from pjpdaf.tracker.hypotheses.blobs import Blobs
from pjpdaf.tracker.hypotheses.geometry import Views

ROWS_M = -0.03, -0.015, 0.0, 0.015, 0.03  # below the centre of the skin
MOST_M = 0.06  # on either side; what is beyond is not the head's


def hair_beside(mean: Floats, seen: tuple[Blobs, ...], views: Views) -> float | None:
    """Mean width [m] of both sides' hair beside the face; None where no view shows it.

    mean (3,) [m]: centre of the head's visible skin.
    """
    pixels, depth = views.project(mean)
    widths = []
    for v, blobs in enumerate(seen):
        shape = blobs.looks.silhouette
        if shape is None:
            continue
        metre = float(views.focal_px[v] / depth[v]) / shape.step_px
        column, row = ((pixels[v] + 0.5) / shape.step_px).astype(int)
        rows = row + np.rint(np.array(ROWS_M) * metre).astype(int)
        height, width = shape.classes.shape
        if not (0 <= column < width and rows[0] >= 0 and rows[-1] < height):
            continue
        most = int(MOST_M * metre)
        view = [_beside(line, int(column), most) for line in shape.classes[rows]]
        known = [pixels_beside for pixels_beside in view if pixels_beside is not None]
        if known:
            widths.append(float(np.mean(known)) / metre)
    return float(np.mean(widths)) if widths else None


def _beside(classes: NDArray[np.uint8], column: int, most: int) -> int | None:
    """Pixels of the person beside the run of skin that holds a column, at most so many a side."""
    if classes[column] != SKIN:
        return None
    total = 0
    for side in (classes[column::-1], classes[column:]):
        rest = side[_run(side == SKIN) :]
        total += min(_run(rest > 0), most)
    return total


def _run(true: NDArray[np.bool_]) -> int:
    """Length of the run of true values that an array begins with."""
    return int(true.argmin()) if not true.all() else len(true)
