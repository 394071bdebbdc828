"""Candidates: places in one view at which a hand may be, and pairs of them over two views."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Floats
from pjpdaf.detector.blob_detector import BlobDetections
from pjpdaf.detector.silhouette import CLOTHED
from pjpdaf.detector.split import ends, halves, outside, pieces
from pjpdaf.tracker.hypotheses.geometry import Views, stereo_information
from pjpdaf.tracker.hypotheses.parameters import (
    CandidateParameters,
    CostParameters,
    NoiseParameters,
)

Ints = NDArray[np.intp]
WHOLE, HALF, OTHER_HALF, BESIDE, END, OTHER_END = range(6)
NEAREST_M, FARTHEST_M = 0.3, 5.0
WHOLE_COST = 2.0  # two blobs agree as they are below this cost
LONGEST_FINGERS = 0.4  # of the square root of the area
PART_M = 0.30  # parts of a blob are no further from its centre


@dataclass(frozen=True, eq=False)
class Candidates:
    """Of one view: centres (c, 2) [px], areas (c,) [px], blob (c,) and part (c,), WHOLE .. END.

    palm_px (c, 2): from the centre to the middle of the palm, 0 for parts. cost (c,): of its own.
    """

    centres_px: Floats
    areas_px: Floats
    blob: Ints
    part: Ints
    palm_px: Floats
    cost: Floats


@dataclass(frozen=True, eq=False)
class Head:
    """Where the head is in a view: blob it belongs to (-1: none), centre (2,), shape (2, 2)."""

    blob: int
    free: bool
    centre_px: Floats
    shape_px2: Floats


def candidates(
    view: BlobDetections,
    head: Head | None,
    depth_m: float,
    focal_px: float,
    bare: bool,
    p: CandidateParameters,
) -> Candidates:
    """All candidates of a view; the blob of the head offers only what is beside the head.

    bare: the person's forearms are bare, so that the hand is an end of a long blob.
    """
    metre_px = focal_px / depth_m
    centres: list[Floats] = []
    costs: dict[int, float] = {}
    rest: list[tuple[float, int, int]] = []
    for blob in range(len(view)):
        pixels = view.pixels[blob] if view.pixels else None
        area = float(view.areas_px[blob])
        if head is not None and blob == head.blob:
            if head.free or pixels is None or not p.beside_head:
                continue
            left = outside(pixels, head.centre_px, head.shape_px2, p.head_scale)
            least = int(p.beside_area_m2 * metre_px**2 / view.pixel_area_px)
            for piece in pieces(left, view.pixel_area_px**0.5, max(least, 6))[:3]:
                centres.append(piece.mean(axis=0))
                rest.append((len(piece) * view.pixel_area_px, blob, BESIDE))
                if p.halves and len(piece) * view.pixel_area_px > 1.2 * p.split_area_m2 * metre_px**2:
                    two = halves(piece, p.draw_together)
                    if two is not None:
                        for k in range(2):
                            centres.append(two[0][k])
                            rest.append((float(two[1][k]) * len(piece) * view.pixel_area_px, blob, HALF + k))
            continue
        length_m = 2.0 * float(view.ellipses[blob, 2]) / metre_px
        arm = bare and p.ends and pixels is not None and length_m > p.hand_length_m
        if arm:
            found, tips = ends(pixels, 0.8 * p.hand_length_m * metre_px)
            cloth = [_clothed(view, tip, 0.045 * metre_px) for tip in tips]
            for k in range(2):
                costs[len(centres)] = 5.0 * max(0.0, cloth[k] - cloth[1 - k])
                centres.append(found[k])
                rest.append((min(area, p.split_area_m2 * metre_px**2), blob, END + k))
        if not arm or head is None:  # the head itself may be long, at the start
            centres.append(view.centres_px[blob])
            rest.append((area, blob, WHOLE))
        if pixels is None:
            continue
        if p.halves and area > p.split_area_m2 * metre_px**2:
            two = halves(pixels, p.draw_together)
            if two is not None:
                for k in range(2):
                    centres.append(two[0][k])
                    rest.append((area * float(two[1][k]), blob, HALF + k))
    areas, blobs, parts = (list(x) for x in zip(*rest, strict=True)) if rest else ([], [], [])
    blob, part = np.array(blobs, np.intp), np.array(parts, np.intp)
    palm = np.zeros((len(blob), 2))
    whole = part == WHOLE
    if view.fingers is not None:
        away = np.clip(view.fingers[blob[whole]], -LONGEST_FINGERS, LONGEST_FINGERS)
        palm[whole] = -p.palm * away * np.sqrt(view.areas_px[blob[whole]])[:, None]
    return Candidates(
        np.array(centres).reshape(-1, 2), np.array(areas, np.float64), blob, part, palm,
        np.array([costs.get(k, 0.0) for k in range(len(blob))]),
    )


def _clothed(view: BlobDetections, at_px: Floats, radius_px: float) -> float:
    """Share of clothed pixels within a distance of a pixel (2,); 0 without a silhouette."""
    if view.silhouette is None:
        return 0.0
    classes, step = view.silhouette.classes, view.silhouette.step_px
    x, y = (at_px + 0.5) / step
    r = max(radius_px / step, 1.0)
    rows, columns = classes.shape
    top, left = max(int(y - r), 0), max(int(x - r), 0)
    box = classes[top : min(int(y + r) + 1, rows), left : min(int(x + r) + 1, columns)]
    return float((box == CLOTHED).mean()) if box.size else 0.0


def blob_length_m(view: BlobDetections, blob: int, depth_m: float, focal_px: float) -> float:
    """Length of a blob's ellipse [m]."""
    return 2.0 * float(view.ellipses[blob, 2]) * depth_m / focal_px


@dataclass(frozen=True, eq=False)
class Pairs:
    """Sightings of a hand: points (n, 3) [m], covariance (n, 3, 3), area (n,) [m^2], the cost of
    each by itself (n,), blob (n, 2) and part (n, 2) of each view, -1 where it is unseen there.
    """

    points_m: Floats
    covariances_m2: Floats
    areas_m2: Floats
    cost: Floats
    blob: Ints
    part: Ints

    def __len__(self) -> int:
        return len(self.points_m)

    def __getitem__(self, chosen: NDArray[np.bool_] | Ints) -> Pairs:
        return Pairs(*(getattr(self, name)[chosen] for name in self.__dataclass_fields__))


def pairs(
    views: Views,
    found: tuple[Candidates, Candidates],
    expected_m: Floats,
    noise: NoiseParameters,
    costs: CostParameters,
) -> Pairs:
    """All stereo-consistent pairs, and single sightings of whole blobs without a partner.

    expected_m (h, 3): where hands are expected, which gives a single sighting its depth.
    """
    left, right = found
    i, j = (a.ravel() for a in np.indices((len(left.blob), len(right.blob))))
    points, residual = views.triangulate(left.centres_px[i], right.centres_px[j])
    _, depth = views.project(points)
    size = (depth / views.focal_px[:, None]) ** 2
    a, b = left.areas_px[i] * size[0], right.areas_px[j] * size[1]
    whole = (left.part[i] == WHOLE) & (right.part[j] == WHOLE)
    loose = np.where(whole, 1.0, 1.5) * costs.epipolar_px * views.scale
    epipolar = 0.5 * (2.0 * residual / loose) ** 2
    between = 0.5 * (np.log(np.maximum(a, 1e-9) / np.maximum(b, 1e-9)) / 0.5) ** 2
    same_kind = (left.part[i] + 1) // 2 == (right.part[j] + 1) // 2
    own = epipolar + np.minimum(between, 3.0) + np.where(same_kind, 0.0, 1.0)
    own = own + left.cost[i] + right.cost[j]
    sane = (epipolar < 8.0) & (depth > NEAREST_M).all(0) & (depth < FARTHEST_M).all(0)
    sane &= _coherent(left, right, i, j, points, own, whole)
    if len(expected_m):
        reach = np.linalg.norm(points[:, None] - expected_m[None], axis=2).min(axis=1)
        sane &= reach < 1.2
    i, j, points, own = i[sane], j[sane], points[sane], own[sane]
    area, whole = np.sqrt(a * b)[sane], whole[sane]
    common = np.where(whole, noise.whole_px[0], noise.part_px[0]) * views.scale
    apart = np.where(whole, noise.whole_px[1], noise.part_px[1]) * views.scale
    information = stereo_information(views.jacobians(points), common, apart)
    points = points + _to_palms(views, left.palm_px[i], right.palm_px[j], depth[:, sane])
    double = Pairs(
        points,
        np.linalg.inv(information) if len(points) else np.zeros((0, 3, 3)),
        area,
        own,
        np.stack([left.blob[i], right.blob[j]], axis=1),
        np.stack([left.part[i], right.part[j]], axis=1),
    )
    singles = [
        _single(views, v, found[v], double, expected_m, noise, costs) for v in range(2)
    ]
    return _joined([double, *singles])


def _to_palms(views: Views, left_px: Floats, right_px: Floats, depth: Floats) -> Floats:
    """Displacements (n, 3) [m] across the line of sight; the mean of both views'.

    The depth is left to the centroids, which the views share better than the palms.
    """
    metre = depth / views.focal_px[:, None]
    across = 0.5 * (left_px * metre[0][:, None] + right_px * metre[1][:, None])
    return np.asarray(across @ views.axes[:2])


def _coherent(
    left: Candidates,
    right: Candidates,
    i: Ints,
    j: Ints,
    points: Floats,
    own: Floats,
    whole: NDArray[np.bool_],
) -> NDArray[np.bool_]:
    """Which pairs (n,) can be one thing: parts of blobs that agree as a whole lie near that whole.

    A whole blob pairs with a part of another only where the two blobs do not agree as they are:
    the hands are merged in one view alone.
    """
    good = np.ones(len(i), bool)
    ends_left, ends_right = left.part[i] >= END, right.part[j] >= END
    good &= ~(ends_left ^ ends_right) | (left.part[i] == WHOLE) | (right.part[j] == WHOLE)
    for k in np.flatnonzero(whole & (own < WHOLE_COST)):
        same = (left.blob[i] == left.blob[i[k]]) & (right.blob[j] == right.blob[j[k]])
        mixed = (left.part[i] == WHOLE) ^ (right.part[j] == WHOLE)
        far = np.linalg.norm(points - points[k], axis=1) > PART_M
        good &= ~(same & (mixed | far))
    return good


def _single(
    views: Views,
    view: int,
    found: Candidates,
    double: Pairs,
    expected_m: Floats,
    noise: NoiseParameters,
    costs: CostParameters,
) -> Pairs:
    """Candidates of a view that pair with nothing, at the depth of the nearest expected hand."""
    partnered = np.isin(found.blob, double.blob[:, view])
    at = np.flatnonzero(~partnered & ((found.part == WHOLE) | (found.part == BESIDE)))
    if not len(at) or not len(expected_m):
        return double[np.zeros(0, np.intp)]
    pixels, depth = views.project(expected_m)
    d = np.linalg.norm(found.centres_px[at][:, None] - pixels[view][None], axis=2)
    depth_m = depth[view][d.argmin(axis=1)]
    rays = views.rays(view, found.centres_px[at])
    points = views.centres_m[view] + depth_m[:, None] * rays
    H = views.jacobians(points)[:, view]
    sd = 2.0 * noise.whole_px[0] * views.scale
    unit = rays / np.linalg.norm(rays, axis=1, keepdims=True)
    information = H.swapaxes(1, 2) @ H / sd**2 + unit[:, :, None] * unit[:, None, :] / 0.12**2
    size = (depth_m / views.focal_px[view]) ** 2
    blob = np.full((len(at), 2), -1)
    part = np.full((len(at), 2), -1)
    blob[:, view], part[:, view] = found.blob[at], found.part[at]
    cost = np.full(len(at), costs.single_view)
    return Pairs(
        points, np.linalg.inv(information), found.areas_px[at] * size, cost, blob, part
    )


def _joined(parts: list[Pairs]) -> Pairs:
    return Pairs(
        *(np.concatenate([getattr(p, n) for p in parts]) for n in Pairs.__dataclass_fields__)
    )
