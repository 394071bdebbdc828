"""Bare arms: the ends of a blob along its own course, of which one is the hand."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pjpdaf.arrays import Floats, Ints

if TYPE_CHECKING:
    from scipy.sparse import csr_array

OUTSIDE = 0.7  # share of a hand that is seen outside the face that it reaches to
NEIGHBOURS = (1, 0), (0, 1), (1, 1), (1, -1)  # columns, rows; each way once


def courses(pixels: Floats, step_px: float, start: Floats | None = None) -> tuple[Floats, ...]:
    """Ways [px] within a blob from one end and from the other to each of its pixels (n, 2).

    The ends are the two pixels farthest from each other by a way within the blob, so that an arm
    that is bent has its ends at hand and sleeve, not at the elbow. start (2,): one end is the pixel
    nearest to it. step_px: of the pixels' lattice. Pixels of other pieces than the first end's are
    infinitely far.
    """
    from scipy.sparse.csgraph import dijkstra  # late: most episodes have long sleeves

    graph = _graph(pixels, step_px)

    def ways(i: int) -> Floats:
        return np.asarray(dijkstra(graph, directed=False, indices=i))

    if start is None:
        middle = int(((pixels - pixels.mean(axis=0)) ** 2).sum(axis=1).argmin())
        one = _farthest(ways(middle))
    else:
        one = int(((pixels - start) ** 2).sum(axis=1).argmin())
    from_one = ways(one)
    return from_one, ways(_farthest(from_one))


def ends_and_middles(
    pixels: Floats, step_px: float, length_px: float
) -> tuple[tuple[Floats, Floats], tuple[Floats, Floats]]:
    """The last length_px of a blob's pixels (n, 2) at either end, and as much of hands that meet in
    the middle of a blob of two arms.

    How far the other end is by way of the arm tells what is last: a thumb and a finger alike. The
    middles are in the order of the ends: each hand is on its own arm's side.
    """
    one, other = courses(pixels, step_px)
    joined = np.isfinite(one) & np.isfinite(other)
    inside, one, other = pixels[joined], one[joined], other[joined]
    tips = _last(inside, one, length_px), _last(inside, other, length_px)
    half = 0.5 * length_px
    along = 0.5 * (one - other)  # 0 in the middle of the way, > 0 towards the first's last part
    hands = inside[np.abs(along - half) <= half], inside[np.abs(along + half) <= half]
    return tips, hands


def end_at(pixels: Floats, step_px: float, goal: Floats, length_px: float) -> Floats:
    """Centre (2,) of a hand of length_px at the end of an arm that reaches to something at goal.

    Pixels (n, 2) are of the arm outside it. The fingers, or less, are inside.
    """
    way, _ = courses(pixels, step_px, goal)
    return np.asarray(pixels[way <= OUTSIDE * length_px].mean(axis=0))


def _last(pixels: Floats, way: Floats, length_px: float) -> Floats:
    return np.asarray(pixels[way >= np.percentile(way, 99) - length_px])


def _farthest(ways: Floats) -> int:
    return int(np.where(np.isfinite(ways), ways, -1.0).argmax())


def _graph(pixels: Floats, step_px: float) -> csr_array:
    """Distances [px] between neighbours on the lattice."""
    from scipy.sparse import csr_array

    cells: Ints = np.rint((pixels - pixels.min(axis=0)) / step_px).astype(np.intp)
    columns, rows = (int(size) + 3 for size in cells.max(axis=0))
    number = np.full((rows, columns), -1, np.intp)
    x, y = cells[:, 0] + 1, cells[:, 1] + 1
    number[y, x] = np.arange(len(pixels))
    here = number[y, x]  # of two pixels in one cell the last
    heads, tails, lengths = [], [], []
    for right, down in NEIGHBOURS:
        other = number[y + down, x + right]
        joined = other >= 0
        heads.append(here[joined])
        tails.append(other[joined])
        lengths.append(np.full(int(joined.sum()), step_px * float(np.hypot(right, down))))
    size = (len(pixels), len(pixels))
    parts = np.concatenate(lengths), (np.concatenate(heads), np.concatenate(tails))
    return csr_array(parts, shape=size)
