"""Stereo labels: where the surface that a pixel shows lies in the other view.

Of the pictures as they are (`PicturePair`), and of the rectified pair (`RectifiedPair`), both from
the two views' depths at the same moment. A surface point is HIDDEN where the other view's depth is
nearer than the point in all pixels around its position (four in the pictures, two of a row in the
rectified pair), by more than the width of a pixel there. Depth is never interpolated: on a plane,
however slanted, no point lies behind the farthest of the pixels around it, and in a square corner
by less than a pixel's width. So a surface never hides itself, and a point within a pixel behind an
edge, or in the outer half of the border's pixels, may still be called SEEN.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Floats
from pjpdaf.calibration import rectify
from pjpdaf.camera import Camera, StereoRig
from sim.camera.render import NO_LENS
from sim.dataset.labels.records import HIDDEN, NO_SURFACE, OUT_OF_FRAME, SEEN, Matches
from sim.lens import Lens, ideal_pixels, real_pixels

Float32s = NDArray[np.float32]
Depths = tuple[Float32s, Float32s]
SAME_PX = 1e-3  # pixels that lie nearer than this are the same


@dataclass(frozen=True, eq=False)
class RectifiedRig:
    """The rectified pair of a rig: R1 R2 P1 P2 of `pjpdaf.calibration.rectify`.

    cameras: its two ideal cameras. disparity = baseline_px_m / depth + shift_px; focal_px: of both.
    """

    cameras: tuple[Camera, Camera]
    focal_px: float
    baseline_px_m: float
    shift_px: float

    @classmethod
    def of(cls, rig: StereoRig) -> RectifiedRig:
        """Rectify a rig."""
        R1, R2, P1, P2, *_ = rectify(rig)
        left, right = (
            replace(
                camera,
                K=P[:, :3],
                R_cw=R @ camera.R_cw,
                t_cw=R @ camera.t_cw,
                distortion=NO_LENS,
            )
            for camera, R, P in zip(rig.cameras, (R1, R2), (P1, P2), strict=True)
        )
        shift_px = float(P1[0, 2] - P2[0, 2])
        return cls((left, right), float(P1[0, 0]), -float(P2[0, 3]), shift_px)


class RectifiedPair:
    """Matches in the rectified pair of a rig.

    cameras: its two ideal cameras, to be rendered. drawn: False where they are the rig's own to
    SAME_PX (parallel, no lens), so that the views' own depth serves. covered: per view, the pixels
    (h, w) of the rectified picture that the real picture reaches; the others are black and have no
    label.
    """

    def __init__(self, rig: StereoRig, lenses: tuple[Lens | None, ...]) -> None:
        self._rig = RectifiedRig.of(rig)
        self.cameras = self._rig.cameras
        self.drawn = any(lenses) or not all(
            _same(own, ideal) for own, ideal in zip(rig.cameras, self.cameras, strict=True)
        )
        self.covered = tuple(
            _covered(ideal, own, lens)
            for ideal, own, lens in zip(self.cameras, rig.cameras, lenses, strict=True)
        )

    def matches(self, depths_m: Depths) -> tuple[Matches, Matches]:
        """Matches of both views from the depths (h, w) of `cameras`, NaN for nothing."""
        left, right = (self._of(view, depths_m) for view in (0, 1))
        return left, right

    def _of(self, view: int, depths_m: Depths) -> Matches:
        own, other = depths_m[view], depths_m[1 - view]
        height, width = own.shape
        there = np.isfinite(own) & self.covered[view]
        z = np.where(there, own, np.float32(1.0))
        disparity = np.float32(self._rig.baseline_px_m) / z + np.float32(self._rig.shift_px)
        x = np.arange(width, dtype=np.float32) + (disparity if view else -disparity)
        inside = (x >= -0.5) & (x < width - 0.5)
        first = np.clip(np.floor(x), -1, width - 1).astype(np.int32) + 1
        nearest = np.clip(np.floor(x + np.float32(0.5)), 0, width - 1).astype(np.int32)
        row = np.arange(height, dtype=np.int32)[:, None]
        inside &= np.take(self.covered[1 - view], row * width + nearest)
        far = _farthest(other, rows=False)
        met = np.take(far, row * far.shape[1] + first)
        status = status_of(there, inside, z, met, self._rig.focal_px)
        return Matches(status, disparity_px=np.where(there, disparity, np.float32(np.nan)))


class PicturePair:
    """Matches between the pictures of a rig as they are, with vergence and lenses."""

    def __init__(self, rig: StereoRig, lenses: tuple[Lens | None, ...]) -> None:
        self._cameras, self._lenses = rig.cameras, lenses
        # Of a pixel's surface at depth z, K X in the other camera is slope * z + start.
        self._slopes: list[Float32s] = []
        self._starts: list[Float32s] = []
        for own, other in ((rig.left, rig.right), (rig.right, rig.left)):
            turn = other.R_cw @ own.R_cw.T
            start = other.K @ (other.t_cw - turn @ own.t_cw)
            slope = np.moveaxis(pixel_rays(own) @ (other.K @ turn).T, -1, 0)
            self._slopes.append(np.ascontiguousarray(slope, np.float32))
            self._starts.append(start.astype(np.float32))

    def matches(self, depths_m: Depths) -> tuple[Matches, Matches]:
        """Matches of both views from their depths (h, w), NaN for nothing.

        Positions may lie outside the other picture; they are NaN only behind its camera and beyond
        the reach of its lens.
        """
        left, right = (self._of(view, depths_m) for view in (0, 1))
        return left, right

    def _of(self, view: int, depths_m: Depths) -> Matches:
        own, other = depths_m[view], depths_m[1 - view]
        camera = self._cameras[1 - view]
        nan = np.float32(np.nan)
        qx, qy, z = (
            slope * own + start
            for slope, start in zip(self._slopes[view], self._starts[view], strict=True)
        )
        scale = 1 / np.where(z > 0, z, nan)
        x, y = real_pixels(camera, self._lenses[1 - view], qx * scale, qy * scale)
        inside, met = met_at(other, x, y)
        status = status_of(np.isfinite(own), inside, z, met, float(camera.K[0, 0]))
        return Matches(status, places_px=np.stack([x, y], axis=-1))


def met_at(depth_m: Float32s, x: Float32s, y: Float32s) -> tuple[NDArray[np.bool_], Float32s]:
    """Which positions (...) [px] lie inside a picture (h, w), and its farthest depth around each.

    The depth of a position outside means nothing.
    """
    height, width = depth_m.shape
    inside = (x >= -0.5) & (x < width - 0.5) & (y >= -0.5) & (y < height - 0.5)
    column, row = (np.where(inside, np.floor(v), 0).astype(np.int32) + 1 for v in (x, y))
    far = _farthest(depth_m, rows=True)
    return inside, np.take(far, row * far.shape[1] + column)


def status_of(
    there: NDArray[np.bool_],
    inside: NDArray[np.bool_],
    depth_m: Float32s,
    met_m: Float32s,
    focal_px: float,
) -> NDArray[np.uint8]:
    """Status (...) of pixels of a view.

    there: the pixel shows a surface; inside: its point lies in the other picture; depth_m: of the
    point in the other camera; met_m: the other view's farthest depth around it.
    """
    status = np.where(depth_m > met_m * np.float32(1 + 1 / focal_px), HIDDEN, SEEN)
    status = np.where(inside, status, OUT_OF_FRAME)
    return np.where(there, status, NO_SURFACE).astype(np.uint8)


def _farthest(depth_m: Float32s, rows: bool) -> Float32s:
    """Farthest depth (h, w + 1) of pixels (x - 1, x); with rows (h + 1, w + 1) of y - 1, y too.

    Infinite where a pixel shows nothing or is outside the picture.
    """
    far = np.where(np.isfinite(depth_m), depth_m, np.float32(np.inf))
    far = np.pad(far, ((int(rows), int(rows)), (1, 1)), constant_values=np.inf)
    far = np.maximum(far[:, :-1], far[:, 1:])
    return np.maximum(far[:-1], far[1:]) if rows else far


def pixel_rays(camera: Camera) -> Floats:
    """Rays (h, w, 3) of the real picture's pixels, z = 1, in the camera's frame."""
    at = ideal_pixels(camera)
    return np.asarray(np.dstack([at, np.ones(at.shape[:2])]) @ np.linalg.inv(camera.K).T)


def _same(own: Camera, ideal: Camera) -> bool:
    """Whether two cameras in one place show the same picture, to SAME_PX."""
    ends = np.array([[x, y, 1.0] for x in (0, own.width_px - 1) for y in (0, own.height_px - 1)])
    moved = ends @ (ideal.K @ ideal.R_cw @ own.R_cw.T @ np.linalg.inv(own.K)).T
    return bool(np.abs(moved[:, :2] / moved[:, 2:] - ends[:, :2]).max() < SAME_PX)


def _covered(ideal: Camera, own: Camera, lens: Lens | None) -> NDArray[np.bool_]:
    """Which pixels (h, w) of a rectified picture lie inside the real one."""
    turn = own.R_cw @ ideal.R_cw.T
    q = np.moveaxis(pixel_rays(ideal) @ (own.K @ turn).T, -1, 0)
    x, y = real_pixels(own, lens, *(q[:2] / np.where(q[2] > 0, q[2], np.nan)).astype(np.float32))
    # To SAME_PX: where nothing is moved, the border's pixels are inside.
    low, right, below = -0.5 - SAME_PX, own.width_px - 0.5, own.height_px - 0.5
    return np.asarray(
        (x >= low) & (x <= right + SAME_PX) & (y >= low) & (y <= below + SAME_PX), np.bool_
    )
