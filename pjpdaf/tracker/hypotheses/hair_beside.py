"""Hair beside the face: how much of the silhouette beside the face's skin is no skin."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Floats, Ints
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
        lines = shape.classes[rows]
        lines = lines[lines[:, column] == SKIN]
        if len(lines):
            widths.append(float(_beside(lines, int(column), most).mean()) / metre)
    return float(np.mean(widths)) if widths else None


def _beside(lines: NDArray[np.uint8], column: int, most: int) -> Ints:
    """Pixels (k,) of the person beside the run of skin round a column, at most so many a side.

    lines (k, w): classes of rows of a silhouette.
    """
    total = np.zeros(len(lines), np.intp)
    for side in (lines[:, column::-1], lines[:, column:]):
        total += np.minimum(_run(side > 0) - _run(side == SKIN), most)
    return total


def _run(true: NDArray[np.bool_]) -> Ints:
    """Length (k,) of the run of true values that each row (k, w) begins with."""
    return np.asarray(np.where(true.all(axis=1), true.shape[1], true.argmin(axis=1)))
