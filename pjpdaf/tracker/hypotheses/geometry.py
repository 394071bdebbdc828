"""Two-view geometry of many points at once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.camera import Camera


@dataclass(frozen=True, eq=False)
class Views:
    """What the tracker needs of N cameras, as arrays.

    M (N, 3, 4) projection [px]; back (N, 3, 3) pixel (x, y, 1) -> ray in the world; centres_m
    (N, 3); focal_px (N,); axes (3, 3) rows right, down, forward of the first camera in the world;
    scale: pictures' width over 640 [1].
    """

    M: Floats
    back: Floats
    centres_m: Floats
    focal_px: Floats
    axes: Floats
    scale: float

    @staticmethod
    def of(cameras: tuple[Camera, ...]) -> Views:
        """The views of calibrated cameras."""
        return Views(
            np.array([c.M for c in cameras]),
            np.array([c.R_cw.T @ np.linalg.inv(c.K) for c in cameras]),
            np.array([c.centre_w for c in cameras]),
            np.array([(c.K[0, 0] * c.K[1, 1]) ** 0.5 for c in cameras]),
            np.array(cameras[0].R_cw),
            cameras[0].width_px / 640.0,
        )

    def project(self, points_w: Floats) -> tuple[Floats, Floats]:
        """Pixels (N, ..., 2) and depths (N, ...) [m] of world points (..., 3)."""
        flat = points_w.reshape(-1, 3)
        q = flat @ self.M[:, :, :3].transpose(0, 2, 1) + self.M[:, None, :, 3]
        depth = np.maximum(q[..., 2], 1e-3)
        shape = points_w.shape[:-1]
        pixels = (q[..., :2] / depth[..., None]).reshape(len(self.M), *shape, 2)
        return pixels, depth.reshape(len(self.M), *shape)

    def jacobians(self, points_w: Floats) -> Floats:
        """d pixel / d point (n, N, 2, 3) [px/m] at world points (n, 3)."""
        pixels, depth = self.project(points_w)
        slope = self.M[:, None, :2, :3] - pixels[..., None] * self.M[:, None, 2:, :3]
        return np.asarray((slope / depth[..., None, None]).swapaxes(0, 1))

    def rays(self, view: int, pixels: Floats) -> Floats:
        """Directions (n, 3) of pixels (n, 2), of depth 1."""
        homogeneous = np.concatenate([pixels, np.ones((len(pixels), 1))], axis=1)
        return np.asarray(homogeneous @ self.back[view].T)

    def triangulate(self, left_px: Floats, right_px: Floats) -> tuple[Floats, Floats]:
        """Points (n, 3) nearest to both rays, and their residuals (n,) [px], rms over 4 numbers."""
        a, b = self.rays(0, left_px), self.rays(1, right_px)
        base = self.centres_m[1] - self.centres_m[0]
        aa, ab, bb = (a * a).sum(1), (a * b).sum(1), (b * b).sum(1)
        det = np.maximum(aa * bb - ab * ab, 1e-12)
        along_a = (bb * (a @ base) - ab * (b @ base)) / det
        along_b = (ab * (a @ base) - aa * (b @ base)) / det
        points = 0.5 * (
            self.centres_m[0] + along_a[:, None] * a + self.centres_m[1] + along_b[:, None] * b
        )
        pixels, _ = self.project(points)
        off = np.concatenate([pixels[0] - left_px, pixels[1] - right_px], axis=1)
        residual = np.sqrt((off * off).mean(axis=1))
        return points, np.where((along_a > 0) & (along_b > 0), residual, np.inf)


def stereo_information(H: Floats, common_px: Floats, between_px: Floats) -> Floats:
    """Information (n, 3, 3) [1/m^2] of points seen in two views.

    H (n, 2, 2, 3). The error of a pixel has a part common to both views (the same finger is
    hidden in both) and a part of its own: R = common^2 + between^2 on the diagonal, common^2 off it
    (`common_px`, `between_px` (n,)).
    """
    total, shared = common_px**2 + between_px**2, common_px**2
    det = total**2 - shared**2
    own, cross = (total / det)[:, None, None], (-shared / det)[:, None, None]
    left, right = H[:, 0], H[:, 1]
    leftT, rightT = left.swapaxes(1, 2), right.swapaxes(1, 2)
    mixed = leftT @ right
    return np.asarray(
        own * (leftT @ left + rightT @ right) + cross * (mixed + mixed.swapaxes(1, 2))
    )
