"""Skin pixels to ellipses: components, k-means hypotheses, moments (thesis 3.1.2)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Floats
from pjpdaf.camera import Camera, undistort_points

Ints = NDArray[np.intp]

FRAGMENT_MIN_PX = 4  # smaller specks are noise that the opening left
FRAGMENTS_MAX = 40  # a picture with more is noise; joining them would cost time and mean nothing
# Beyond this many components the hypotheses 1 .. N + 2 cost seconds and the scene is not three
# targets: the components themselves are reported.
COMPONENTS_MAX = 16
SAMPLE_MIN_PX = 400  # k-means never sees fewer pixels than this, whatever `subsample` says
KMEANS_SEED = 20090701  # fixed: the same picture gives the same bytes
KMEANS_STOP = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 30, 0.02)  # rounds, px
KMEANS_ATTEMPTS = 3


@dataclass(frozen=True, eq=False)
class Segments:
    """Accepted skin pixels of one picture: points (n, 2) whole x, y; component (n,) in 0..count-1;
    size (height, width) of the picture [px].
    """

    points: Ints
    component: Ints
    count: int
    size: tuple[int, int]


@dataclass(frozen=True, eq=False)
class Moments:
    """Ellipses by moments: centres (k, 2) [px], covariances (k, 2, 2) [px^2], areas (k,) [px]."""

    centres: Floats
    covariances: Floats
    areas: Floats

    def __len__(self) -> int:
        return len(self.centres)


def clean(mask: np.ndarray, open_px: int, close_px: int) -> np.ndarray:
    """Opening, then closing of a uint8 mask (h, w) by discs of these diameters [px]; <= 1: none."""
    for diameter, operation in ((open_px, cv2.MORPH_OPEN), (close_px, cv2.MORPH_CLOSE)):
        if diameter > 1:
            disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (int(diameter), int(diameter)))
            mask = cv2.morphologyEx(mask, operation, disc)
    return mask


def segments(mask: np.ndarray, min_area_px: float, merge_fragments: bool) -> Segments:
    """8-connected components of a uint8 mask (h, w) with at least min_area_px pixels.

    merge_fragments: a component under min_area_px joins the nearest one that is not further away
    than its own diameter (one only, so two large components never become one), and the area counts
    after that.
    """
    size = (mask.shape[0], mask.shape[1])
    x0, y0, width, height = cv2.boundingRect(mask)
    if width == 0:
        return Segments(np.zeros((0, 2), np.intp), np.zeros(0, np.intp), 0, size)
    box = mask[y0 : y0 + height, x0 : x0 + width]
    count, labels, stats, _ = cv2.connectedComponentsWithStats(box, connectivity=8)
    areas = stats[:, cv2.CC_STAT_AREA].astype(np.float64)
    areas[0] = 0.0
    group = np.arange(count)
    if merge_fragments:
        group = _join_fragments(labels, stats, min_area_px)
    total = np.bincount(group, weights=areas, minlength=count)
    kept = np.flatnonzero(total >= max(min_area_px, 1.0))
    number = np.full(count, -1, np.intp)
    number[kept] = np.arange(len(kept))
    of_label = number[group]
    of_label[0] = -1
    if len(kept) == 0:
        return Segments(np.zeros((0, 2), np.intp), np.zeros(0, np.intp), 0, size)
    at = np.flatnonzero(labels.ravel())
    component = of_label[labels.ravel()[at]]
    inside = component >= 0
    at, component = at[inside], component[inside]
    points = np.column_stack([at % width + x0, at // width + y0])
    return Segments(points, component, len(kept), size)


def _join_fragments(labels: np.ndarray, stats: np.ndarray, min_area_px: float) -> Ints:
    """Which component each label (count,) belongs to, fragments joined to their nearest."""
    count = len(stats)
    areas = stats[:, cv2.CC_STAT_AREA]
    parent = np.arange(count)
    small = [i for i in range(1, count) if FRAGMENT_MIN_PX <= areas[i] < min_area_px]
    small = sorted(small, key=lambda i: (-int(areas[i]), i))[:FRAGMENTS_MAX]
    for i in small:
        reach = 2.0 * math.sqrt(float(areas[i]) / math.pi)
        pad = math.ceil(reach)
        x, y, width, height = (int(v) for v in stats[i, :4])
        window = labels[max(y - pad, 0) : y + height + pad, max(x - pad, 0) : x + width + pad]
        other = (window != i) & (window != 0)
        if not other.any():
            continue
        # Distance of each pixel of the window to the fragment (whose pixels are the zeros).
        distance = cv2.distanceTransform(
            (window != i).astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE
        )
        distance[~other] = np.inf
        nearest = int(np.argmin(distance))
        j = int(window.ravel()[nearest])
        root = int(_root(parent, j))
        # A speck must not carry a chain; root == i: the two are each other's nearest.
        if float(distance.ravel()[nearest]) <= reach and areas[j] >= FRAGMENT_MIN_PX and root != i:
            parent[i] = root
    return np.array([_root(parent, i) for i in range(count)], np.intp)


def _root(parent: Ints, i: int) -> int:
    while parent[i] != i:
        i = int(parent[i])
    return i


def moments(points: Ints, labels: Ints, k: int, step: int = 1) -> Moments:
    """First and second moments of the pixels (n, 2) of each label 0..k-1.

    A pixel is a square of `step` px: its own variance step^2 / 12 is part of the second moment, so
    an ellipse drawn in pixels, or a lattice of it, has the covariance of the ellipse itself.
    """
    n = np.bincount(labels, minlength=k).astype(np.float64)
    safe = np.maximum(n, 1.0)
    centres = np.column_stack(
        [np.bincount(labels, weights=points[:, axis], minlength=k) / safe for axis in (0, 1)]
    )
    d = points - centres[labels]
    xx = np.bincount(labels, weights=d[:, 0] * d[:, 0], minlength=k) / safe
    xy = np.bincount(labels, weights=d[:, 0] * d[:, 1], minlength=k) / safe
    yy = np.bincount(labels, weights=d[:, 1] * d[:, 1], minlength=k) / safe
    own = step * step / 12.0
    covariances = np.stack([xx + own, xy, xy, yy + own], axis=-1).reshape(k, 2, 2)
    return Moments(centres, covariances, n * step * step)


def ellipse_error(
    points: Ints, labels: Ints, fit: Moments, size: tuple[int, int], step: int = 1
) -> int:
    """Err = N_C + N_E over all clusters (Eq. 3.1), in pixels of the lattice.

    points (n, 2) on the lattice of multiples of `step`; labels (n,); the ellipse has full semi-axes
    2 sqrt(eigenvalue), that is d^T C^-1 d <= 4, and is counted inside the picture only.
    """
    err = 0
    inverse = np.linalg.inv(fit.covariances)
    d = points - fit.centres[labels]
    A, B, C = (inverse[:, i, j][labels] for i, j in ((0, 0), (0, 1), (1, 1)))
    inside = A * d[:, 0] ** 2 + 2 * B * d[:, 0] * d[:, 1] + C * d[:, 1] ** 2 <= 4.0
    n_inside = np.bincount(labels[inside], minlength=len(fit))
    err += int((~inside).sum())  # N_C
    for cluster in range(len(fit)):
        if fit.areas[cluster] > 0:
            pixels = _ellipse_pixels(fit.centres[cluster], inverse[cluster], size, step)
            err += pixels - int(n_inside[cluster])  # N_E
    return err


def _ellipse_pixels(centre: Floats, inverse: Floats, size: tuple[int, int], step: int) -> int:
    """Lattice points with d^T inverse d <= 4 inside the picture, counted row by row."""
    A, B, C = inverse[0, 0], inverse[0, 1], inverse[1, 1]
    half = 2.0 * math.sqrt(A / (A * C - B * B))
    first = max(math.ceil((centre[1] - half) / step), 0)
    last = min(math.floor((centre[1] + half) / step), (size[0] - 1) // step)
    dy = np.arange(first, last + 1) * step - centre[1]
    root = np.sqrt(np.maximum(B * B * dy * dy - A * (C * dy * dy - 4.0), 0.0))
    low = np.maximum(np.ceil((centre[0] + (-B * dy - root) / A) / step), 0)
    high = np.minimum(np.floor((centre[0] + (-B * dy + root) / A) / step), (size[1] - 1) // step)
    return int(np.maximum(high - low + 1, 0).sum())


def cluster(
    seen: Segments,
    extra_hypotheses: int = 2,
    penalty: float = 5.0,
    subsample: int = 1,
    components_compete: bool = True,
) -> Ints:
    """The best clustering of the skin pixels: a label (n,) in 0..k-1 for each point.

    Hypotheses k = 1 .. N + extra_hypotheses for N components; k-means over every `subsample`-th
    pixel (a square lattice); the smallest Err (1 + k / penalty) wins (Eq. 3.2), the smaller k where
    two are equal. components_compete: for k = N the components themselves compete too; k-means
    alone cuts a head where a hand's centre is nearer.
    """
    N = seen.count
    if N == 0 or N > COMPONENTS_MAX:
        return seen.component
    step, chosen = _lattice(seen, subsample)
    points, component = seen.points[chosen], seen.component[chosen]
    samples = points.astype(np.float32)
    best_err, best_centres = math.inf, None
    for k in range(1, min(N + extra_hypotheses, len(points)) + 1):
        labels, centres = _kmeans(samples, k)
        err = ellipse_error(points, labels, moments(points, labels, k, step), seen.size, step)
        if err * (1 + k / penalty) < best_err:
            best_err, best_centres = err * (1 + k / penalty), centres
    if components_compete:
        fit = moments(points, component, N, step)
        err = ellipse_error(points, component, fit, seen.size, step)
        if err * (1 + N / penalty) <= best_err:
            return seen.component
    assert best_centres is not None
    return _nearest(seen.points, best_centres)


def _lattice(seen: Segments, subsample: int) -> tuple[int, NDArray[np.bool_] | slice]:
    """Step of the sampling lattice [px] and which points lie on it.

    Every component must leave a few points, and all together SAMPLE_MIN_PX.
    """
    step = max(1, round(math.sqrt(subsample)))
    while step > 1:
        on = (seen.points[:, 0] % step == 0) & (seen.points[:, 1] % step == 0)
        each = np.bincount(seen.component[on], minlength=seen.count)
        if int(on.sum()) >= SAMPLE_MIN_PX and each.min() >= 3:
            return step, on
        step -= 1
    return 1, slice(None)


def _kmeans(samples: np.ndarray, k: int) -> tuple[Ints, Floats]:
    """Labels (n,) and centres (k, 2) of float32 samples (n, 2); the same for the same samples."""
    cv2.setRNGSeed(KMEANS_SEED)
    _, labels, centres = cv2.kmeans(
        samples, k, None, KMEANS_STOP, KMEANS_ATTEMPTS, cv2.KMEANS_PP_CENTERS
    )
    return labels.ravel().astype(np.intp), np.asarray(centres, dtype=np.float64)


def _nearest(points: Ints, centres: Floats) -> Ints:
    """Index of the nearest centre for each point (n, 2)."""
    squared = ((points[:, None, :] - centres[None]) ** 2).sum(axis=-1)
    nearest: Ints = np.argmin(squared, axis=1)
    return nearest


def undistort_moments(camera: Camera, fit: Moments) -> Moments:
    """The ellipses as a detector would find them in the undistorted picture.

    Four points a cluster, centre +- sqrt(2) sigma along each axis, are undistorted and weighted
    with the area that a pixel there becomes; their mean and covariance are exact to second order in
    the blob's size. (The centre alone was 0.47 px off for a head 134 px from the picture's centre.)
    """
    if len(fit) == 0 or not np.any(camera.distortion):
        return fit
    values, vectors = np.linalg.eigh(fit.covariances)
    arms = math.sqrt(2.0) * np.sqrt(values)[:, :, None] * np.swapaxes(vectors, 1, 2)
    real = np.concatenate([fit.centres[:, None] + arms, fit.centres[:, None] - arms], axis=1)
    # Each of the (k, 4) points, and half a pixel to its right, left, lower and upper side.
    sides = 0.5 * np.array([[0, 0], [1, 0], [-1, 0], [0, 1], [0, -1]])
    around = (real[:, :, None] + sides).reshape(-1, 2)
    ideal = undistort_points(camera, around).reshape(len(fit), 4, 5, 2)
    u, v = ideal[:, :, 1] - ideal[:, :, 2], ideal[:, :, 3] - ideal[:, :, 4]
    area = np.abs(u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0])
    weights = area / area.sum(axis=1, keepdims=True)
    centres = np.einsum("kn,kni->ki", weights, ideal[:, :, 0])
    d = ideal[:, :, 0] - centres[:, None]
    covariances = np.einsum("kn,kni,knj->kij", weights, d, d)
    return Moments(centres, covariances, fit.areas * area.mean(axis=1))


def ellipse_axes(fit: Moments) -> Floats:
    """Ellipses (k, 5): centre x, y, semi-axes a >= b = 2 sqrt(eigenvalue) [px], angle [rad] of the
    major axis from +x towards +y, in (-pi/2, pi/2].
    """
    values, vectors = np.linalg.eigh(fit.covariances)
    axes = 2.0 * np.sqrt(values[:, ::-1])
    angle = np.arctan2(vectors[:, 1, 1], vectors[:, 0, 1])
    angle = np.where(angle > math.pi / 2, angle - math.pi, angle)
    angle = np.where(angle <= -math.pi / 2, angle + math.pi, angle)
    return np.column_stack([fit.centres, axes, angle])
