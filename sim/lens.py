"""Lens distortion: the real picture resampled from a wider ideal pinhole picture."""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Floats
from pjpdaf.camera import Camera, distort_points, undistort_points

SCALE = 2  # both pictures are sampled this much finer per axis
LARGEST = 2.0  # times the real picture's width or height
BORDER_PX, OUTWARD_STEPS = 8, 33  # samples of `check`: along the border, and from the middle to it
ROUND_TRIP_PX = 0.01
POLYNOMIAL = 12  # coefficients of a lens that are polynomials; two more tilt the sensor


@dataclass(frozen=True, eq=False)
class Lens:
    """The position of each pixel of the real picture in the ideal picture.

    ideal: the pinhole to render, same pose and focal lengths, wide enough. colour_map
    (SCALE h, SCALE w, 2) float32: fine real pixel -> fine ideal pixel. corners (4, h, w): flat
    indices of the four fine ideal pixels around the centre of each real pixel, in rows counted from
    below, as OpenGL reads them; weights (4, h, w): their shares of it.
    """

    ideal: Camera
    colour_map: NDArray[np.float32]
    corners: NDArray[np.int64]
    weights: Floats

    def colour(self, fine: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """The real picture at SCALE from the ideal one at SCALE (h, w, 3)."""
        warped: NDArray[np.uint8] = cv2.remap(fine, self.colour_map, None, cv2.INTER_LINEAR)
        return warped

    def ids(self, fine: NDArray[np.int32]) -> tuple[NDArray[np.int32], NDArray[np.bool_]]:
        """Real ids (h, w) from the ideal ones at SCALE as OpenGL reads them, and where they hold.

        They do not where the four ids around a pixel's centre differ: an edge passes there.
        """
        around = np.take(fine.ravel(), self.corners)
        return around[0], (around == around[0]).all(axis=0)

    def inverse_depth(
        self, fine: NDArray[np.float32], step: float
    ) -> tuple[Floats, NDArray[np.bool_]]:
        """Real values (h, w), linear in 1/z, from the ideal ones at SCALE; exact on planes.

        It does not hold where slopes change by more than a step from one fine pixel to the next.
        """
        mixed = (np.take(fine.ravel(), self.corners) * self.weights).sum(axis=0)
        bend = np.zeros_like(fine)
        bend[:, 1:-1] = np.abs(fine[:, 2:] - 2 * fine[:, 1:-1] + fine[:, :-2])
        across = np.abs(fine[2:] - 2 * fine[1:-1] + fine[:-2])
        np.maximum(bend[1:-1], across, out=bend[1:-1])
        even = np.take((bend <= step).ravel(), self.corners)
        return np.asarray(mixed), np.all(even, axis=0)


def lens_of(camera: Camera) -> Lens | None:
    """The lens of a camera, None without distortion.

    Raises as `check`.
    """
    if not np.any(camera.distortion):
        return None
    check(camera)
    at = ideal_pixels(camera)
    low = np.floor(at.min(axis=(0, 1))) - 2
    high = np.ceil(at.max(axis=(0, 1))) + 2
    size = high - low + 1
    K = np.array(camera.K)
    K[:2, 2] -= low
    ideal = replace(
        camera, K=K, width_px=int(size[0]), height_px=int(size[1]), distortion=np.zeros(0)
    )
    fine = (finer(at, SCALE) - low + 0.5) * SCALE - 0.5
    corners, weights = _around((at - low + 0.5) * SCALE - 0.5, ideal)
    return Lens(ideal, fine.astype(np.float32), corners, weights)


def _around(at: Floats, ideal: Camera) -> tuple[NDArray[np.int64], Floats]:
    """`Lens.corners` and `Lens.weights` of places (h, w, 2) in the fine ideal picture."""
    first = np.floor(at).astype(np.int64)
    (x0, y0), (fx, fy) = np.moveaxis(first, -1, 0), np.moveaxis(at - first, -1, 0)
    width, height = SCALE * ideal.width_px, SCALE * ideal.height_px
    corners = [(height - 1 - y) * width + x for y in (y0, y0 + 1) for x in (x0, x0 + 1)]
    weights = [wy * wx for wy in (1 - fy, fy) for wx in (1 - fx, fx)]
    return np.array(corners), np.array(weights)


def check(camera: Camera) -> None:
    """Raise ValueError for a lens that cannot be rendered.

    Its ideal picture would be over LARGEST times as big, or it shows a point of the world twice:
    a point further from the picture's middle is shown nearer to it.
    """
    if not np.any(camera.distortion):
        return
    width, height = camera.width_px, camera.height_px
    x, y = np.arange(0, width, BORDER_PX), np.arange(0, height, BORDER_PX)
    border = np.concatenate(
        [np.column_stack([x, np.full(len(x), row)]) for row in (0, height - 1)]
        + [np.column_stack([np.full(len(y), column), y]) for column in (0, width - 1)]
        + [[[width - 1.0, height - 1.0]]]
    )
    ideal = undistort_points(camera, border)
    too_strong = f"lens distortion {tuple(camera.distortion.tolist())} is too strong to render"
    size = np.ptp(ideal, axis=0)
    if not np.all(size <= LARGEST * np.array([width, height])):
        pixels = f"{size[0]:.0f} x {size[1]:.0f} pixels"
        raise ValueError(f"{too_strong}: the ideal picture would have {pixels}")
    middle = camera.K[:2, 2]
    outwards = np.linspace(0.0, 1.0, OUTWARD_STEPS)[:, None, None]
    shown = distort_points(camera, (middle + outwards * (ideal - middle)).reshape(-1, 2))
    distance = np.linalg.norm(shown.reshape(-1, *border.shape) - middle, axis=-1)
    met = np.abs(shown[-len(border) :] - border).max() < ROUND_TRIP_PX
    if not met or not np.all(np.diff(distance, axis=0) > 0):
        raise ValueError(f"{too_strong}: it shows some points twice")


def ideal_pixels(camera: Camera) -> Floats:
    """Ideal pixel (h, w, 2) of each real pixel."""
    y, x = np.mgrid[: camera.height_px, : camera.width_px]
    real = np.stack([x.ravel(), y.ravel()], axis=-1)
    return undistort_points(camera, real).reshape(*x.shape, 2)


def real_pixels(
    camera: Camera, lens: Lens | None, x: NDArray[np.float32], y: NDArray[np.float32]
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Real pixels x, y of ideal pixels x, y, of the pinhole with the camera's K.

    NaN beyond the ideal picture, where the lens may show nothing, or fold.
    """
    if lens is None:
        return x, y
    low = camera.K[:2, 2] - lens.ideal.K[:2, 2]
    high = low + np.array([lens.ideal.width_px, lens.ideal.height_px]) - 1
    known = (x >= low[0]) & (x <= high[0]) & (y >= low[1]) & (y <= high[1])
    x, y = np.where(known, x, np.float32(np.nan)), np.where(known, y, np.float32(np.nan))
    if len(camera.distortion) > POLYNOMIAL:
        at = distort_points(camera, np.stack([x.ravel(), y.ravel()], axis=-1)).astype(np.float32)
        return at[:, 0].reshape(x.shape), at[:, 1].reshape(x.shape)
    # OpenCV's own formula; its function takes ten times as long.
    fx, cx, fy, cy = (np.float32(camera.K[i]) for i in ((0, 0), (0, 2), (1, 1), (1, 2)))
    given = np.zeros(POLYNOMIAL, np.float32)
    given[: len(camera.distortion)] = camera.distortion
    k1, k2, p1, p2, k3, k4, k5, k6, s1, s2, s3, s4 = given
    u, v = (x - cx) / fx, (y - cy) / fy
    r2, uv2 = u * u + v * v, 2 * u * v
    radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
    if k4 or k5 or k6:
        radial = radial / (1 + r2 * (k4 + r2 * (k5 + r2 * k6)))
    return (
        fx * (u * radial + p1 * uv2 + p2 * (r2 + 2 * u * u) + r2 * (s1 + r2 * s2)) + cx,
        fy * (v * radial + p1 * (r2 + 2 * v * v) + p2 * uv2 + r2 * (s3 + r2 * s4)) + cy,
    )


def finer(at: Floats, scale: int) -> Floats:
    """A smooth map of pixels (h, w, 2), sampled at `scale` per axis: (scale h, scale w, 2).

    By its slope at each pixel: exact to 0.002 px for lenses that can be rendered.
    """
    shift = (np.arange(scale) + 0.5) / scale - 0.5
    down, right = (np.asarray(np.gradient(at, axis=axis)) for axis in (0, 1))
    rows = at[:, None] + shift[:, None, None] * down[:, None]
    fine = rows[:, :, :, None] + shift[:, None] * right[:, None, :, None]
    return np.asarray(fine.reshape(scale * at.shape[0], scale * at.shape[1], 2))
