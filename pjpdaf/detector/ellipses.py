"""Ellipses of clusters of pixels: moments, Err of Eq. 3.1, undistortion (thesis 3.1.2)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pjpdaf.arrays import Floats, Ints
from pjpdaf.camera import Camera, undistort_points


@dataclass(frozen=True, eq=False)
class Moments:
    """Ellipses by moments: centres (k, 2) [px], covariances (k, 2, 2) [px^2], areas (k,) [px]."""

    centres: Floats
    covariances: Floats
    areas: Floats

    def __len__(self) -> int:
        return len(self.centres)


def moments(points: Ints, labels: Ints, k: int, step: int = 1) -> Moments:
    """Return first and second moments of the pixels (n, 2) of each label 0..k-1.

    A pixel is a square of `step` px: its own variance step^2 / 12 is part of the second moment, so
    an ellipse drawn in pixels, or a lattice of it, has the covariance of the ellipse itself.
    """
    n = np.bincount(labels, minlength=k).astype(np.float64)
    safe = np.maximum(n, 1.0)
    # Columns of their own: twice as fast as axes of 2.
    columns = np.ascontiguousarray(points.T, np.float64)
    centres = np.column_stack(
        [np.bincount(labels, weights=column, minlength=k) / safe for column in columns]
    )
    x, y = (column - centres[:, axis][labels] for axis, column in enumerate(columns))
    xx = np.bincount(labels, weights=x * x, minlength=k) / safe
    xy = np.bincount(labels, weights=x * y, minlength=k) / safe
    yy = np.bincount(labels, weights=y * y, minlength=k) / safe
    own = step * step / 12.0
    covariances = np.stack([xx + own, xy, xy, yy + own], axis=-1).reshape(k, 2, 2)
    return Moments(centres, covariances, n * step * step)


def ellipse_error(
    points: Ints, labels: Ints, fit: Moments, size: tuple[int, int], step: int = 1
) -> int:
    """Count Err = N_C + N_E over all clusters (Eq. 3.1), in pixels of the lattice.

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


def undistort_moments(camera: Camera, fit: Moments) -> Moments:
    """Move ellipses to where they are in the undistorted picture.

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
