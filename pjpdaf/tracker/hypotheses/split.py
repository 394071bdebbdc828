"""Splitting a blob into the parts that may be hands: pure functions of its pixels."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Floats, mean_point

ROUNDS = 6  # of 2-means; it has long converged
LEAST = 8  # pixels of a blob that is halved, or of an ellipse's


def halves(pixels: Floats, together: float) -> tuple[Floats, Floats] | None:
    """Centres (2, 2) [px] of the two clusters of a blob's pixels (n, 2), and their shares (2,).

    2-means from the ends of the major axis; then both are drawn towards their middle, `together` of
    their distance remains. None for fewer than 8 pixels.
    """
    if len(pixels) < LEAST:
        return None
    centre = mean_point(pixels)
    offset = pixels - centre
    axis = np.linalg.eigh(offset.T @ offset)[1][:, 1]
    along = offset @ axis
    second = along > 0.0
    x, y = columns = np.ascontiguousarray(pixels.T)  # numpy reduces an axis of 2 slowly
    for _ in range(ROUNDS):
        (ax, bx), (ay, by) = means_of_parts(columns, second)
        now = (x - ax) ** 2 + (y - ay) ** 2 > (x - bx) ** 2 + (y - by) ** 2
        if np.array_equal(now, second) or now.all() or not now.any():
            break
        second = now
    centres = np.array([[ax, ay], [bx, by]])
    middle = centres.mean(axis=0)
    share = float(second.mean())
    return middle + together * (centres - middle), np.array([1.0 - share, share])


def means_of_parts(columns: Floats, second: NDArray[np.bool_]) -> Floats:
    """Means (2, 2) of rows (2, n), of the values that are not in the second part, and of others."""
    part = second.astype(np.intp)
    count = np.bincount(part, minlength=2)
    return np.array([np.bincount(part, weights=c, minlength=2) / count for c in columns])


def squared_distance(pixels: Floats, centre: Floats, inverse: NDArray[np.floating]) -> Floats:
    """Squares (n,) of the Mahalanobis distances of pixels (n, 2), by an inverse covariance."""
    offset = pixels - centre
    product = (offset @ inverse) * offset
    return np.asarray(product[:, 0] + product[:, 1])  # numpy reduces an axis of 2 slowly


def outside(pixels: Floats, centre: Floats, shape: Floats, scale: float) -> Floats:
    """The pixels (n, 2) outside an ellipse: d^T shape^-1 d > 4 scale^2."""
    d2 = squared_distance(pixels, centre, np.linalg.inv(shape))
    return np.asarray(pixels[d2 > 4.0 * scale * scale])


def pieces(pixels: Floats, step_px: float, least: int) -> list[Floats]:
    """Connected pieces of lattice pixels (n, 2), at least `least` of them, largest first.

    Two pixels are connected within 1.6 steps of the lattice along each axis.
    """
    if len(pixels) < least:
        return []
    cells = np.rint((pixels - pixels.min(axis=0)) / step_px).astype(int)
    size = cells.max(axis=0) + 1
    grid = np.zeros((size[1], size[0]), np.uint8)
    grid[cells[:, 1], cells[:, 0]] = 1
    count, labels = cv2.connectedComponents(grid, connectivity=8)
    label = labels[cells[:, 1], cells[:, 0]]
    components = [pixels[label == i] for i in range(1, count)]
    return sorted((p for p in components if len(p) >= least), key=len, reverse=True)


def settle(pixels: Floats, start: Floats, shape: Floats) -> tuple[Floats, float]:
    """Where an ellipse comes to rest on a blob (mean shift), (2,), and the pixels inside it."""
    inverse = np.linalg.inv(shape)
    centre = np.array(start)
    inside = np.zeros(len(pixels), bool)
    for _ in range(5):
        inside = squared_distance(pixels, centre, inverse) <= 4.0
        if np.count_nonzero(inside) < LEAST:
            break
        moved = mean_point(pixels[inside])
        if np.abs(moved - centre).max() < 0.3:
            break
        centre = moved
    return centre, float(np.count_nonzero(inside))
