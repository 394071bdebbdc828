"""Pairs: candidates of two views that may be one hand, as points in the world."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Floats, Ints
from pjpdaf.tracker.hypotheses.blobs import Blobs
from pjpdaf.tracker.hypotheses.border import agreed_centres, cut_sides
from pjpdaf.tracker.hypotheses.candidates import BESIDE, END, WHOLE, Candidates
from pjpdaf.tracker.hypotheses.contour import RowEnds, disparity, row_ends, row_shift
from pjpdaf.tracker.hypotheses.geometry import Views, stereo_information
from pjpdaf.tracker.hypotheses.parameters import CostParameters, NoiseParameters
from pjpdaf.tracker.hypotheses.skew import Skewed

NEAREST_M, FARTHEST_M = 0.3, 5.0  # depths at which a hand can be
FARTHEST_MOVE_M = 1.2  # from where some hand is expected
WHOLE_COST = 2.0  # two blobs agree as they are below this cost
PART_M = 0.30  # parts of a blob are no further from its centre
ALONG_RAY_M = 0.12  # deviation of the depth of a hand that only one view shows
LOG_AREA_SD = 0.5  # between the areas that two views show
ALIKE_LOG_AREA = 0.15  # what the views' directions alone make of it
MOST_CHANGE_PX = 8.0  # of a part's place, by its outline
CUT_ROWS_PX = 25.0  # from the row that is expected, of a hand that the picture's edge cuts
PARTNER_M = 0.35  # from where some hand is expected
SANE_COST = 8.0  # of the epipolar error


@dataclass(frozen=True, eq=False)
class Pairs:
    """Sightings of a hand.

    points_m (n, 3); covariances_m2 (n, 3, 3); areas_m2 (n,); cost (n,) of each by itself; blob
    (n, 2), part (n, 2) and candidate (n, 2) in each view, -1 where it is unseen.
    """

    points_m: Floats
    covariances_m2: Floats
    areas_m2: Floats
    cost: Floats
    blob: Ints
    part: Ints
    candidate: Ints

    def __len__(self) -> int:
        return len(self.points_m)

    def __getitem__(self, chosen: NDArray[np.bool_] | Ints) -> Pairs:
        return Pairs(
            self.points_m[chosen],
            self.covariances_m2[chosen],
            self.areas_m2[chosen],
            self.cost[chosen],
            self.blob[chosen],
            self.part[chosen],
            self.candidate[chosen],
        )


def pair_candidates(
    views: Views,
    candidates: tuple[Candidates, Candidates],
    expected_m: Floats,
    noise: NoiseParameters,
    costs: CostParameters,
    seen: tuple[Blobs, ...] | None = None,
    skewed: Skewed | None = None,
) -> Pairs:
    """All stereo-consistent pairs, and single sightings of candidates without a partner.

    expected_m (h, 3): where hands are expected, which gives a single sighting its depth. seen: the
    views' blobs, for places and depths from their outlines. skewed: of views whose moments differ.
    """
    double = _stereo(views, candidates, expected_m, noise, costs, seen, skewed)
    singles = [_single(views, v, candidates[v], double, expected_m, noise, costs) for v in range(2)]
    return _joined([double, *singles])


def _stereo(
    views: Views,
    candidates: tuple[Candidates, Candidates],
    expected_m: Floats,
    noise: NoiseParameters,
    costs: CostParameters,
    seen: tuple[Blobs, ...] | None,
    skewed: Skewed | None,
) -> Pairs:
    left, right = candidates
    i, j = (a.ravel() for a in np.indices((len(left.blob), len(right.blob))))
    whole = (left.part[i] == WHOLE) & (right.part[j] == WHOLE)
    left_px, right_px = left.centres_px[i], right.centres_px[j]
    corrected = np.zeros(len(i), np.bool_)
    if seen is not None and costs.cut_hands and whole.any():
        blobs = np.stack([left.blob[i], right.blob[j]], axis=1)
        corrected = _correct_cut(views, seen, blobs, whole, left_px, right_px)
    uncertain_px = np.zeros(len(i))
    if skewed is not None:
        right_px, uncertain_px = skewed.undone(views, left_px, right_px, whole)
    points, residual = views.triangulate(left_px, right_px)
    _, depth = views.project(points)
    size = (depth / views.focal_px[:, None]) ** 2
    a, b = left.areas_px[i] * size[0], right.areas_px[j] * size[1]
    loose_px = np.where(whole, 1.0, 1.5) * costs.epipolar_px * views.scale
    epipolar = 0.5 * (2.0 * residual / loose_px) ** 2
    ratio = np.log(np.maximum(a, 1e-9) / np.maximum(b, 1e-9)) / LOG_AREA_SD
    ratio[corrected] = 0.0
    same_kind = (left.part[i] + 1) // 2 == (right.part[j] + 1) // 2
    own = epipolar + np.minimum(0.5 * ratio**2, 3.0) + np.where(same_kind, 0.0, 1.0)
    sane: NDArray[np.bool_] = (
        (epipolar < SANE_COST) & (depth > NEAREST_M).all(0) & (depth < FARTHEST_M).all(0)
    )
    sane &= (left.mate[i] < 0) | (left.mate[i] == j)
    sane &= (right.mate[j] < 0) | (right.mate[j] == i)
    sane &= _coherent(left.part[i], left.blob[i], right.part[j], right.blob[j], points, own)
    if len(expected_m):
        reach = np.linalg.norm(points[:, None] - expected_m[None], axis=2).min(axis=1)
        sane &= reach < FARTHEST_MOVE_M
    i, j, points, whole = i[sane], j[sane], points[sane], (whole & ~corrected)[sane]
    if seen is not None and costs.contours:
        points = _by_contours(views, seen, candidates, i, j, points)
    mated = left.mate[i] >= 0
    common = np.where(whole, noise.whole_px[0], noise.part_px[0]) * views.scale
    apart = np.where(whole, noise.whole_px[1], noise.part_px[1]) * views.scale
    apart = np.where(mated, left.between_px[i], apart)
    points[mated] -= noise.halves_behind_m * views.axes[2]
    # What one view alone hides of a hand has moved that view's centre alone.
    unlike = np.maximum(np.abs(ratio[sane]) * LOG_AREA_SD - ALIKE_LOG_AREA, 0.0)
    radius_px = np.sqrt(np.maximum(left.areas_px[i], right.areas_px[j]) / np.pi)
    apart = np.hypot(apart, noise.hidden_share * unlike * radius_px)
    apart = np.hypot(apart, uncertain_px[sane])
    information = stereo_information(views.jacobians(points), common, apart)
    return Pairs(
        points + _to_palms(views, left.palm_px[i], right.palm_px[j], depth[:, sane], noise.tilt),
        np.asarray(np.linalg.inv(information)),
        np.where(corrected, np.maximum(a, b), np.sqrt(a * b))[sane],
        own[sane],
        np.stack([left.blob[i], right.blob[j]], axis=1),
        np.stack([left.part[i], right.part[j]], axis=1),
        np.stack([i, j], axis=1),
    )


def _correct_cut(
    views: Views,
    seen: tuple[Blobs, ...],
    blobs: Ints,
    whole: NDArray[np.bool_],
    left_px: Floats,
    right_px: Floats,
) -> NDArray[np.bool_]:
    """Correct, in place, the centres of blobs (n, 2) that the picture's edge cuts; which those are.

    A blob may lack up to half in one view: pairs that are far from the same row are left alone.
    """
    sides = [cut_sides(view, views) for view in seen]
    corrected = np.zeros(len(blobs), np.bool_)
    for k in np.flatnonzero(whole):
        one, two = (int(blob) for blob in blobs[k])
        side = int(sides[0][one] or sides[1][two])
        centres = agreed_centres(views, seen, (one, two), side) if side else None
        if centres is not None and abs(centres[1][1] - right_px[k, 1]) < CUT_ROWS_PX * views.scale:
            left_px[k], right_px[k] = centres
            corrected[k] = True
    return corrected


def _by_contours(
    views: Views,
    seen: tuple[Blobs, ...],
    candidates: tuple[Candidates, Candidates],
    i: Ints,
    j: Ints,
    points: Floats,
) -> Floats:
    """Points (n, 3) of parts with the depth of their own outlines, where these show it.

    The line that splits a blob says nothing of the depth of either part.
    """
    left, right = candidates
    step = seen[0].looks.pixel_area_px ** 0.5
    ends: dict[tuple[int, int], RowEnds] = {}

    def of(view: int, k: int) -> RowEnds:
        if (view, k) not in ends:
            part, c = candidates[view].pixels[k], candidates[view]
            assert part is not None
            down = row_shift(views, c.centres_px[k]) if view else 0.0
            ends[view, k] = row_ends(part, seen[view].looks.pixels[c.blob[k]], step, down)
        return ends[view, k]

    left_px, right_px = left.centres_px[i].copy(), right.centres_px[j].copy()
    changed = []
    for n, (a, b) in enumerate(zip(i.tolist(), j.tolist(), strict=True)):
        if left.pixels[a] is None or right.pixels[b] is None:
            continue
        wanted = disparity(of(0, a), of(1, b))
        if wanted is None:
            continue
        change = 0.5 * (wanted - (left_px[n, 0] - right_px[n, 0]))
        if abs(change) > MOST_CHANGE_PX * views.scale:
            continue
        left_px[n, 0] += change
        right_px[n, 0] -= change
        changed.append(n)
    if not changed:
        return points
    moved = points.copy()
    moved[changed] = views.triangulate(left_px[changed], right_px[changed])[0]
    return moved


def _to_palms(
    views: Views, left_px: Floats, right_px: Floats, depth: Floats, tilt: float
) -> Floats:
    """Displacements (n, 3) [m] across the line of sight, the mean of both views', and with it.

    The disparity is left to the centroids, which the views share better than the palms; a palm
    above the skin's centre is behind it, as the hand's fingers point at the camera.
    """
    metre = depth / views.focal_px[:, None]
    across = 0.5 * (left_px * metre[0][:, None] + right_px * metre[1][:, None])
    return np.asarray(np.column_stack([across, -tilt * across[:, 1]]) @ views.axes)


def _coherent(
    left_part: Ints,
    left_blob: Ints,
    right_part: Ints,
    right_blob: Ints,
    points: Floats,
    own: Floats,
) -> NDArray[np.bool_]:
    """Which pairs (n,) can be one thing: parts of blobs that agree as a whole lie near that whole.

    A whole blob pairs with a part of another only where the two blobs do not agree as they are:
    the hands are merged in one view alone.
    """
    one_end = (left_part >= END) ^ (right_part >= END)
    one_whole = (left_part == WHOLE) ^ (right_part == WHOLE)
    good: NDArray[np.bool_] = ~one_end | one_whole
    both = (left_part == WHOLE) & (right_part == WHOLE)
    for k in np.flatnonzero(both & (own < WHOLE_COST)):
        same = (left_blob == left_blob[k]) & (right_blob == right_blob[k])
        far = np.linalg.norm(points - points[k], axis=1) > PART_M
        good &= ~(same & (one_whole | far))
    return good


def _single(
    views: Views,
    view: int,
    candidates: Candidates,
    double: Pairs,
    expected_m: Floats,
    noise: NoiseParameters,
    costs: CostParameters,
) -> Pairs:
    """Candidates of a view that pair with nothing, at the depth of the nearest expected hand."""
    partners = double.blob[:, view]
    if len(expected_m) and len(double):
        off = np.linalg.norm(double.points_m[:, None] - expected_m[None], axis=2).min(axis=1)
        partners = partners[off < PARTNER_M]
    partnered = np.isin(candidates.blob, partners)
    at = np.flatnonzero(~partnered & ((candidates.part == WHOLE) | (candidates.part == BESIDE)))
    if not len(at) or not len(expected_m):
        return double[np.zeros(0, np.intp)]
    pixels, depth = views.project(expected_m)
    distance = np.linalg.norm(candidates.centres_px[at][:, None] - pixels[view][None], axis=2)
    depth_m = depth[view][distance.argmin(axis=1)]
    rays = views.rays(view, candidates.centres_px[at])
    points = views.centres_m[view] + depth_m[:, None] * rays
    H = views.jacobians(points)[:, view]
    sd_px = 2.0 * noise.whole_px[0] * views.scale
    unit = rays / np.linalg.norm(rays, axis=1, keepdims=True)
    along = unit[:, :, None] * unit[:, None, :] / ALONG_RAY_M**2
    information = H.swapaxes(1, 2) @ H / sd_px**2 + along
    size = (depth_m / views.focal_px[view]) ** 2
    blob, part = np.full((len(at), 2), -1), np.full((len(at), 2), -1)
    blob[:, view], part[:, view] = candidates.blob[at], candidates.part[at]
    candidate = np.full((len(at), 2), -1)
    candidate[:, view] = at
    cost = np.full(len(at), costs.single_view)
    covariances = np.asarray(np.linalg.inv(information))
    areas = candidates.areas_px[at] * size
    return Pairs(points, covariances, areas, cost, blob, part, candidate)


def _joined(parts: list[Pairs]) -> Pairs:
    return Pairs(
        np.concatenate([p.points_m for p in parts]),
        np.concatenate([p.covariances_m2 for p in parts]),
        np.concatenate([p.areas_m2 for p in parts]),
        np.concatenate([p.cost for p in parts]),
        np.concatenate([p.blob for p in parts]),
        np.concatenate([p.part for p in parts]),
        np.concatenate([p.candidate for p in parts]),
    )
