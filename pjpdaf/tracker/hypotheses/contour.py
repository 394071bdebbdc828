"""Depth of a part of a blob: the disparity of those sides that are the part's own."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.tracker.hypotheses.geometry import Views

LEAST_ENDS = 4  # of rows that both views show
NEAR_M, FAR_M = 0.8, 1.6  # depths that span an epipolar line


@dataclass(frozen=True, eq=False)
class RowEnds:
    """Ends (k, 2) [px] left and right of a part in successive rows of the lattice, from row low on.

    NaN where the row has no pixel of the part, or where the blob goes on beyond the end.
    """

    low: int
    ends: Floats


def row_ends(part: Floats, blob: Floats, step: float, down_px: float = 0.0) -> RowEnds:
    """Ends of a part's pixels (n, 2) in the lattice's rows that are ends of the whole blob (m, 2).

    down_px is taken from all rows, so that those of two views are comparable.
    """
    low, own = ends_of_rows(part, step, down_px)
    first, whole = ends_of_rows(blob, step, down_px)
    if not len(own):
        return RowEnds(low, own)
    whole = whole[low - first : low - first + len(own)]
    free = np.abs(own - whole) < 0.5 * step
    return RowEnds(low, np.where(free, own, np.nan))


def ends_of_rows(pixels: Floats, step: float, down_px: float = 0.0) -> tuple[int, Floats]:
    """First row of pixels (n, 2), and their ends (k, 2) [px] left and right in it and those below.

    NaN where a row of the lattice has no pixel. down_px is taken from all rows.
    """
    rows = np.rint((pixels[:, 1] - down_px) / step).astype(int)
    x = pixels[:, 0]
    if (rows[1:] < rows[:-1]).any():  # of a lattice they come in order, but for the lens
        order = np.argsort(rows, kind="stable")
        rows, x = rows[order], x[order]
    starts = np.flatnonzero(np.concatenate([[True], rows[1:] != rows[:-1]]))
    low = int(rows[0])
    ends = np.full((int(rows[-1]) - low + 1, 2), np.nan)
    ends[rows[starts] - low, 0] = np.minimum.reduceat(x, starts)
    ends[rows[starts] - low, 1] = np.maximum.reduceat(x, starts)
    return low, ends


def disparity(left: RowEnds, right: RowEnds) -> float | None:
    """Median distance [px] of free ends in the left view from those in the right one.

    None where fewer than LEAST_ENDS are free in both.
    """
    low = max(left.low, right.low)
    high = min(left.low + len(left.ends), right.low + len(right.ends))
    if high <= low:
        return None
    off = (
        left.ends[low - left.low : high - left.low] - right.ends[low - right.low : high - right.low]
    )
    known = off[np.isfinite(off)]
    return float(np.median(known)) if len(known) >= LEAST_ENDS else None


def row_shift(views: Views, point_px: Floats) -> float:
    """How far [px] below a point of the left view its like in the right one is, at usual depths."""
    ray = views.rays(0, point_px[None])[0]
    middle = views.centres_m[0] + 0.5 * (NEAR_M + FAR_M) * ray
    return float(views.project(middle)[0][1, 1] - point_px[1])
