"""Splitting a blob that both views show into two hands: one cut, made in both views at once.

Each view by itself cuts where its own pixels are best parted, and cuts at two places give depths of
neither hand. Here the sides of the silhouette decide: of hands at different depths, the ends of the
rows on either side of the right cut agree in one disparity, and across a wrong one they do not.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Floats, mean_point
from pjpdaf.tracker.hypotheses.blobs import Blobs
from pjpdaf.tracker.hypotheses.candidates import (
    HALF,
    WHOLE,
    Candidates,
    drawn_together,
    hidden_share,
)
from pjpdaf.tracker.hypotheses.contour import ends_of_rows, row_shift
from pjpdaf.tracker.hypotheses.geometry import Views
from pjpdaf.tracker.hypotheses.parameters import CandidateParameters
from pjpdaf.tracker.hypotheses.split import halves, means_of_parts

ANGLES = np.arange(12) * (np.pi / 12)
ACROSS = np.column_stack([np.cos(ANGLES), np.sin(ANGLES)])  # normals of the cuts
SHARES = np.array([0.35, 0.5, 0.65])  # of the pixels before a cut
LEAST_ENDS = 4  # of each part
FAR_PX = 15.0  # an end whose disparity differs so much from the blob's belongs to something else
MOST_PX = 4.0  # that an end counts against a cut
COMPACT_PX = 2.0  # cost of parts as wide as the undivided blob
OWN_PX, ONE_HAND_PX, ONE_DEPTH_PX = 0.8, 50.0, 4.0  # deviations of the parts' depths
ONE_BLOB_PX = 6.0  # residual of the views' centres of one blob
ALIKE_LOG_AREA = 0.5  # of one blob in the two views


@dataclass(frozen=True, eq=False)
class StereoSplit:
    """The two parts of a blob: centres (2, 2) [px] in the left and in the right view; shares (2,)
    of its pixels.
    """

    left_px: Floats
    right_px: Floats
    shares: Floats

    def between_px(self, hidden: float, scale: float) -> float:
        """Deviation of the parts' places between the views; hidden: share of the two hands.

        Where hands are hidden and both parts have one disparity, the outlines may all be of one.
        """
        disparity = (self.left_px - self.right_px)[:, 0]
        apart = abs(float(disparity[0] - disparity[1])) / (ONE_DEPTH_PX * scale)
        alone = ONE_HAND_PX * max(hidden, 0.0) * np.exp(-0.5 * apart * apart)
        return scale * float(np.hypot(OWN_PX, alone))


def split_together(
    left: Floats, right: Floats, step: float, down_px: float, scale: float
) -> StereoSplit | None:
    """Split a blob's pixels in both views (n, 2), (m, 2), on lattices of step px.

    down_px: how far its rows are lower in the right view; scale: pictures' width over 640. None
    where too few rows are common.
    """
    right = right - np.array([0.0, down_px])
    c, other = mean_point(left), mean_point(right)
    ends, d = _disparities(left, right, step, float(c[0] - other[0]), FAR_PX * scale)
    if len(d) < 2 * LEAST_ENDS:
        return None
    a, b = left - c, right - other
    along_a, along_b = ACROSS @ a.T, ACROSS @ b.T  # (angles, pixels)
    cut = np.sort(along_a, axis=1)[:, (SHARES * len(a)).astype(int)]
    in_a, beyond = (
        (along[:, None] > cut[..., None]).reshape(-1, along.shape[1])  # (cuts, pixels or ends)
        for along in (along_a, ACROSS @ (ends - c).T)
    )
    count = np.count_nonzero(beyond, axis=1)
    possible = (count >= LEAST_ENDS) & (len(d) - count >= LEAST_ENDS)
    if not possible.any():
        return None
    after, before = _medians(d, beyond)
    medians = np.where(beyond, after[:, None], before[:, None])
    off = np.abs(d - medians)
    inside = np.count_nonzero(in_a, axis=1)
    share = inside / len(a)
    first = in_a @ a / np.maximum(inside, 1)[:, None]  # the other part is opposite
    between = (first**2).sum(axis=1) * share / np.maximum(1.0 - share, 1e-9)
    cost = np.minimum(off, MOST_PX * scale).mean(axis=1)
    x, y = np.ascontiguousarray(a.T)
    cost += COMPACT_PX * scale * (1.0 - between / (x * x + y * y).mean())
    k = int(np.where(possible, cost, np.inf).argmin())
    agree = off[k] <= MOST_PX * scale
    angle, share_of_b = divmod(k, len(SHARES))
    in_b = along_b[angle] > np.sort(along_b[angle])[int(SHARES[share_of_b] * len(b))]
    between_px = [d[agree & (beyond[k] == after)].mean() for after in (False, True)]
    way = np.array([[disparity, 0.0] for disparity in between_px])
    one, two = (
        means_of_parts(np.ascontiguousarray(pixels.T), second).T
        for pixels, second in ((left, in_a[k]), (right, in_b))
    )
    centres = 0.5 * (one + (two + way))
    shifted = centres - np.array([[disparity, -down_px] for disparity in between_px])
    return StereoSplit(centres, shifted, np.array([1.0 - share[k], share[k]]))


def _disparities(
    left: Floats, right: Floats, step: float, common: float, far: float
) -> tuple[Floats, Floats]:
    """Ends of rows in the left view (k, 2), and their disparities (k,), of rows in both views."""
    low_a, a = ends_of_rows(left, step)
    low_b, b = ends_of_rows(right, step)
    low, high = max(low_a, low_b), min(low_a + len(a), low_b + len(b))
    if high <= low:
        return np.zeros((0, 2)), np.zeros(0)
    x = a[low - low_a : high - low_a]
    d = x - b[low - low_b : high - low_b]
    y = np.broadcast_to(np.arange(low, high)[:, None] * step, x.shape)
    near = np.abs(d - common) < far  # NaN is not
    return np.column_stack([x[near], y[near]]), d[near]


def _medians(values: Floats, chosen: NDArray[np.bool_]) -> tuple[Floats, Floats]:
    """Lower medians (c,) of the values (n,) that are chosen (c, n), and of those that are not."""
    order = np.argsort(values, kind="stable")
    counted = np.cumsum(chosen[:, order], axis=1)
    others = np.arange(1, len(values) + 1) - counted
    one, two = (
        values[order][(c >= np.maximum((c[:, -1:] + 1) // 2, 1)).argmax(axis=1)]
        for c in (counted, others)
    )
    return one, two


def halve_together(
    views: Views,
    seen: tuple[Blobs, ...],
    candidates: tuple[Candidates, Candidates],
    hand_px: tuple[float, float],
    p: CandidateParameters,
) -> tuple[Candidates, Candidates]:
    """The candidates, the halves of blobs that both views show cut together, and each other's mate;
    the halves of others that are uncut are cut alone.

    hand_px: area of a whole hand in each view.
    """
    halved = [_halved(c) for c in candidates]
    both = bool(halved[0] and halved[1])
    if not both and not any(c.uncut for c in candidates):
        return candidates
    centres = [c.centres_px.copy() for c in candidates]
    areas = [c.areas_px.copy() for c in candidates]
    mates = [c.mate.copy() for c in candidates]
    betweens = [c.between_px.copy() for c in candidates]
    for blobs in _same(views, seen, list(halved[0]), list(halved[1])) if both else ():
        left, right = (view.looks.pixels[blob] for view, blob in zip(seen, blobs, strict=True))
        down = row_shift(views, seen[0].centres_px[blobs[0]])
        step = seen[0].looks.pixel_area_px ** 0.5
        split = split_together(left, right, step, down, views.scale)
        if split is None:
            continue
        of_blob = [float(view.areas_px[blob]) for view, blob in zip(seen, blobs, strict=True)]
        of_views = list(zip(of_blob, hand_px, strict=True))
        together = sum(drawn_together(area, hand, p) for area, hand in of_views) / 2
        hidden = sum(hidden_share(area, hand) for area, hand in of_views) / 2
        between = split.between_px(hidden, views.scale)
        at = [halved[v][blobs[v]] for v in range(2)]
        middle = mean_point(split.left_px) * (1 - together)
        for v, parts in enumerate((split.left_px, split.right_px)):
            here = slice(at[v], at[v] + 2)
            centres[v][here] = parts + middle - (1 - together) * split.left_px
            areas[v][here] = split.shares * of_blob[v]
            betweens[v][here] = between
            mates[v][here] = at[1 - v] + np.arange(2)
    for v, c in enumerate(candidates):
        for first, share in c.uncut.items():
            blob = int(c.blob[first])
            if mates[v][first] < 0 and (alone := halves(seen[v].looks.pixels[blob], share)):
                here = slice(first, first + 2)
                centres[v][here] = alone[0]
                areas[v][here] = float(seen[v].areas_px[blob]) * alone[1]
    one, two = (
        replace(
            c,
            centres_px=centres[v],
            areas_px=areas[v],
            mate=mates[v],
            between_px=betweens[v],
            uncut={},
        )
        for v, c in enumerate(candidates)
    )
    return one, two


def _halved(c: Candidates) -> dict[int, int]:
    """Blobs that are candidates as a whole and in halves: where the first half is."""
    whole = set(c.blob[c.part == WHOLE].tolist())
    return {int(c.blob[k]): int(k) for k in np.flatnonzero(c.part == HALF) if c.blob[k] in whole}


def _same(
    views: Views, seen: tuple[Blobs, ...], left: list[int], right: list[int]
) -> list[tuple[int, int]]:
    """Pairs of a left and a right blob that are one thing: each the other's best."""
    i, j = np.repeat(left, len(right)), np.tile(right, len(left))
    _, residual = views.triangulate(seen[0].centres_px[i], seen[1].centres_px[j])
    ratio = np.abs(np.log(seen[0].areas_px[i] / seen[1].areas_px[j]))
    cost = residual / (ONE_BLOB_PX * views.scale) + ratio / ALIKE_LOG_AREA
    cost = np.where(
        (residual < ONE_BLOB_PX * views.scale) & (ratio < ALIKE_LOG_AREA), cost, np.inf
    ).reshape(len(left), len(right))
    return [
        (left[a], right[b])
        for a, b in enumerate(cost.argmin(axis=1).tolist())
        if np.isfinite(cost[a, b]) and cost[:, b].argmin() == a
    ]
