"""Rays of a camera's pixels: from depth to points of the world, and back to pixels."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Floats
from pjpdaf.camera import Camera, StereoRig, distort_points, project, to_camera
from sim.dataset.files.layout import DEPTH_UNIT_M, FLOW_SCALE
from sim.dataset.labels.stereo import RectifiedRig
from sim.lens import ideal_pixels

LEAST_CHOSEN = 0.5  # of pixels; off edges lay 73 % and more at 160 x 120, 65 % and more at 64 x 48
PixelIndex = tuple[NDArray[np.intp], NDArray[np.intp]]  # rows (n,), columns (n,)
CLOSES_PX = 0.05
HOME_PX = CLOSES_PX + 2 / FLOW_SCALE  # there and back by places as they are written
JUMP_PX = 1.0  # of disparity from one pixel to the next; more is an edge


class PixelRays:
    """camera: any, with its lens; rays_w (h, w, 3): of its pixels, at depth 1, in the world."""

    def __init__(self, camera: Camera) -> None:
        self.camera = camera
        at = ideal_pixels(camera)
        rays_c = np.dstack([at, np.ones(at.shape[:2])]) @ np.linalg.inv(camera.K).T
        self.rays_w: Floats = rays_c @ camera.R_cw

    @property
    def size(self) -> tuple[int, int]:
        """Height and width [px]."""
        return self.camera.height_px, self.camera.width_px

    def grid(self, step: int) -> PixelIndex:
        """Every step-th pixel of every step-th row."""
        ys, xs = np.mgrid[step // 2 : self.size[0] : step, step // 2 : self.size[1] : step]
        return ys.ravel(), xs.ravel()

    def points(self, at: PixelIndex, depth_m: Floats) -> Floats:
        """World points (n, 3) of pixels with these depths (n,)."""
        return np.asarray(self.rays_w[at] * depth_m[:, None] + self.camera.centre_w)

    def project(self, points_w: Floats) -> tuple[Floats, Floats]:
        """Pixels (n, 2) of world points (n, 3), NaN behind the camera, and depths (n,) [m]."""
        pixels = project(self.camera, points_w)
        depth = np.asarray(to_camera(self.camera, points_w)[:, 2])
        return distort_points(self.camera, pixels), depth

    def backproject(self, pixels: Floats, depth_m: Floats) -> Floats:
        """World points (n, 3) at positions (n, 2) between pixels: the rays are interpolated."""
        rays = np.stack([sample(self.rays_w[..., i], pixels) for i in range(3)], axis=-1)
        return np.asarray(rays * depth_m[:, None] + self.camera.centre_w)


@dataclass(frozen=True, eq=False)
class RigRays:
    """Rays of a rig's two views and of its rectified pair.

    skew_s: the right view is later than the left by this, and by this than the rectified pair.
    """

    views: tuple[PixelRays, PixelRays]
    rectified: RectifiedRig
    rectified_views: tuple[PixelRays, PixelRays]
    skew_s: float

    @classmethod
    def of(cls, rig: StereoRig, skew_s: float) -> RigRays:
        """Rays of a rig; skew_s: delay of its right camera."""
        rectified = RectifiedRig.of(rig)
        left, right = rectified.cameras
        views = PixelRays(rig.left), PixelRays(rig.right)
        return cls(views, rectified, (PixelRays(left), PixelRays(right)), skew_s)

    def is_late(self, view: int) -> bool:
        """Whether a view's own depth is of a later moment than the labels of the pair."""
        return view == 1 and self.skew_s > 0

    def tolerance_px(self, depth_m: Floats) -> Floats:
        """Disparity (n,) that CLOSES_PX and whole units of depth explain at these depths (n,)."""
        return np.asarray(CLOSES_PX + self.scale_px_m / depth_m**2 * DEPTH_UNIT_M)

    def smooth(
        self, picture_m: NDArray[np.floating], pixels: Floats, depth_m: Floats
    ) -> NDArray[np.bool_]:
        """Which positions (n, 2) with depths (n,) lie on no edge or crease of depth (h, w).

        There a depth between four pixels is of no surface: of one instance too, such as a leaf
        and the wall behind it. Whole units of depth bend a plane by two units.
        """
        bend_px = self.scale_px_m * corners(bends(1 / picture_m), pixels).max(axis=0)
        return np.asarray(bend_px <= 2 * self.tolerance_px(depth_m))

    @property
    def scale_px_m(self) -> float:
        """Disparity times depth: focal length times baseline."""
        left, right = (rays.camera for rays in self.views)
        return float(left.K[0, 0] * np.linalg.norm(left.centre_w - right.centre_w))


def select(at: PixelIndex, chosen: NDArray[np.bool_]) -> PixelIndex:
    """The pixels where `chosen` (n,) holds."""
    return at[0][chosen], at[1][chosen]


def positions(at: PixelIndex) -> Floats:
    """Pixels as x, y (n, 2)."""
    return np.column_stack(at[::-1]).astype(np.float64)


def inside(pixels: Floats, size: tuple[int, int]) -> NDArray[np.bool_]:
    """Which positions (n, 2) have four pixels around them; NaN has none."""
    height, width = size
    x, y = pixels[:, 0], pixels[:, 1]
    return np.asarray((x >= 0) & (y >= 0) & (x < width - 1) & (y < height - 1))


def corners(picture: NDArray[np.generic], pixels: Floats) -> NDArray[np.generic]:
    """The four pixels (4, n) around positions that are `inside`."""
    x, y = np.floor(pixels).astype(np.intp).T
    return np.stack([picture[y + dy, x + dx] for dy in (0, 1) for dx in (0, 1)])


def sample(picture: NDArray[np.generic], pixels: Floats) -> Floats:
    """The picture (h, w) at positions (n, 2) that are `inside`: bilinear, in double precision."""
    return bilinear(corners(picture, pixels).astype(np.float64), pixels)


def bends(picture: NDArray[np.floating]) -> Floats:
    """By how much each pixel of a picture (h, w) leaves the line through its neighbours.

    The larger second difference along row and column; infinite beside NaN. A value between four
    pixels is off by no more than they bend, whether it is an edge, a crease or a curve. 1 / depth
    bends nowhere on a plane.
    """
    values = picture.astype(np.float64)
    down = np.pad(np.abs(np.diff(values, 2, axis=0)), ((1, 1), (0, 0)), "edge")
    across = np.pad(np.abs(np.diff(values, 2, axis=1)), ((0, 0), (1, 1)), "edge")
    return np.asarray(np.nan_to_num(np.maximum(down, across), nan=np.inf))


def off_home(places_px: NDArray[np.floating], pixels: Floats, home_px: Floats) -> Floats:
    """How far (n,) [px] from home (n, 2) a picture of places (h, w, 2) leads positions (n, 2).

    NaN where a place around the position is unknown.
    """
    led = np.column_stack([sample(places_px[..., i], pixels) for i in (0, 1)])
    return np.asarray(np.linalg.norm(led - home_px, axis=1))


def straight(places_px: NDArray[np.floating], pixels: Floats) -> NDArray[np.bool_]:
    """Which positions (n, 2) lie on no edge or crease of a picture of places (h, w, 2) [px]."""
    bend_px = np.maximum(*(bends(places_px[..., i]) for i in (0, 1)))
    return np.asarray(corners(bend_px, pixels).max(axis=0) <= 2 * HOME_PX)


def most(chosen: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """The chosen of n pixels, where they are LEAST_CHOSEN or more of them; else all n.

    Damage that makes edges of most pixels must not escape a check of those on none.
    """
    enough = np.count_nonzero(chosen) >= LEAST_CHOSEN * len(chosen)
    return chosen if enough else np.ones_like(chosen)


def bilinear(around: Floats, pixels: Floats) -> Floats:
    """Values (n,) interpolated from `corners` (4, n)."""
    fx, fy = (pixels - np.floor(pixels)).T
    shares = [wy * wx for wy in (1 - fy, fy) for wx in (1 - fx, fx)]
    return np.asarray(np.einsum("in,in->n", np.stack(shares), around))
