"""A camera and the rays of its pixels: what a depth picture says of the world, and back."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Floats
from pjpdaf.camera import Camera, distort_points, project, to_camera
from sim.lens import ideal_pixels

Places = tuple[NDArray[np.intp], NDArray[np.intp]]


class PixelRays:
    """camera: any, with its lens; rays_w (h, w, 3): of its pixels, at depth 1, in the world."""

    def __init__(self, camera: Camera) -> None:
        self.camera = camera
        at = ideal_pixels(camera)
        inside = np.dstack([at, np.ones(at.shape[:2])]) @ np.linalg.inv(camera.K).T
        self.rays_w: Floats = inside @ camera.R_cw

    @property
    def size(self) -> tuple[int, int]:
        """Height and width [px]."""
        return self.camera.height_px, self.camera.width_px

    def grid(self, step: int) -> Places:
        """Rows and columns (n,) of every step-th pixel."""
        ys, xs = np.mgrid[step // 2 : self.size[0] : step, step // 2 : self.size[1] : step]
        return ys.ravel(), xs.ravel()

    def points(self, at: Places, depth_m: Floats) -> Floats:
        """World points (n, 3) of pixels with these depths (n,)."""
        return np.asarray(self.rays_w[at] * depth_m[:, None] + self.camera.centre_w)

    def places(self, points_w: Floats) -> tuple[Floats, Floats]:
        """Where world points (n, 3) are shown: pixels (n, 2), NaN behind; and depths (n,) [m]."""
        pixels = project(self.camera, points_w)
        depth = np.asarray(to_camera(self.camera, points_w)[:, 2])
        return distort_points(self.camera, pixels), depth

    def back(self, places_px: Floats, depth_m: Floats) -> Floats:
        """World points (n, 3) of places between pixels, where the rays are mixed as pixels are."""
        rays = np.stack([between(self.rays_w[..., i], places_px) for i in range(3)], axis=-1)
        return np.asarray(rays * depth_m[:, None] + self.camera.centre_w)


def inside(places_px: Floats, size: tuple[int, int]) -> NDArray[np.bool_]:
    """Which places (n, 2) have four pixels around them; NaN has none."""
    height, width = size
    x, y = places_px[:, 0], places_px[:, 1]
    return np.asarray((x >= 0) & (y >= 0) & (x < width - 1) & (y < height - 1))


def corners(picture: NDArray[np.generic], places_px: Floats) -> NDArray[np.generic]:
    """The four pixels (4, n) around places that are `inside`."""
    x, y = np.floor(places_px).astype(np.intp).T
    return np.stack([picture[y + dy, x + dx] for dy in (0, 1) for dx in (0, 1)])


def between(picture: NDArray[np.generic], places_px: Floats) -> Floats:
    """The picture (h, w) at places (n, 2) that are `inside`: bilinear, in double precision."""
    return mixed(corners(picture, places_px).astype(np.float64), places_px)


def mixed(around: Floats, places_px: Floats) -> Floats:
    """Values (n,) of `corners` (4, n)."""
    fx, fy = (places_px - np.floor(places_px)).T
    shares: Sequence[Floats] = [wy * wx for wy in (1 - fy, fy) for wx in (1 - fx, fx)]
    return np.asarray(np.einsum("in,in->n", np.stack(shares), around))
