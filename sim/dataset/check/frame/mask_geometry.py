"""Pixels, centroid and box of a mask, and which masks touch, computed apart from `sim.labels`."""

from __future__ import annotations

from itertools import combinations

import cv2
import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Floats
from pjpdaf.targets import TARGETS
from sim.labels import TOUCH_PX


def measured(mask: NDArray[np.bool_]) -> tuple[int, Floats, Floats]:
    """Pixels, centroid (2,) and box (4,) x, y, width, height of a mask, NaN where it is empty."""
    rows, columns = (np.count_nonzero(mask, axis=axis) for axis in (1, 0))
    count = int(rows.sum())
    if count == 0:
        return 0, np.full(2, np.nan), np.full(4, np.nan)
    ys, xs = np.flatnonzero(rows), np.flatnonzero(columns)
    centroid = np.array([xs @ columns[xs], ys @ rows[ys]]) / count
    box = xs[0], ys[0], xs[-1] - xs[0] + 1, ys[-1] - ys[0] + 1
    return count, centroid, np.array(box, np.float64)


def merged(seg: NDArray[np.uint8], boxes: Floats) -> NDArray[np.bool_]:
    """Which targets' masks are within TOUCH_PX, directly or in a chain (T, T).

    seg (h, w): instance ids; boxes (T, 4): of the targets' masks, NaN where a mask is empty.
    """
    T = len(TARGETS)
    joined = np.zeros((T, T), bool)
    for a, b in combinations(range(T), 2):
        joined[a, b] = joined[b, a] = _near(seg, 1 + a, 1 + b, boxes[a], boxes[b])
    for middle in range(T):
        joined |= joined[:, [middle]] & joined[middle]
    return joined & ~np.eye(T, dtype=bool)


def _near(seg: NDArray[np.uint8], a: int, b: int, box_a: Floats, box_b: Floats) -> bool:
    reach = TOUCH_PX + 1
    if not (np.isfinite(box_a[0]) and np.isfinite(box_b[0])):
        return False
    low = np.maximum(box_a[:2], box_b[:2]) - reach
    high = np.minimum(box_a[:2] + box_a[2:], box_b[:2] + box_b[2:]) + reach
    if np.any(low >= high):
        return False
    (x0, y0), (x1, y1) = np.maximum(low, 0).astype(int), high.astype(int)
    window = seg[y0:y1, x0:x1]
    if not (window == a).any():
        return False
    away = cv2.distanceTransform((window != a).astype(np.uint8), cv2.DIST_C, 3)
    return bool(np.any(away[window == b] < reach + 0.5))
