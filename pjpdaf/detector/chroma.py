"""Chroma: logarithms of ratios of the channels, and a background test that looks at them alone.

A change of light, a shadow for one, multiplies a pixel's channels and so adds a constant to its
log chroma. A smoothed picture shows differences in it that hue and saturation of single pixels hide
in their noise: a face before a wall of its own colour.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from pjpdaf.arrays import Floats, Ints, readonly
from pjpdaf.detector.background import Background

SMOOTH_PX = 0.8  # of the reduced picture
KEPT_NOISE = 1.0 / (4.0 * np.pi * SMOOTH_PX**2) ** 0.5  # share of the noise that smoothing leaves
LEAST_NOISE = 0.7  # of a pixel of the reduced picture [grey levels]
FLOOR = 0.011  # deviation of log chroma that light itself makes
THRESHOLD = 18.4  # 99.99 % point of chi-square with 2 degrees of freedom
THRESHOLD_ALONE = 8.0  # of a pixel that was not smoothed
EVERY = 3  # pixels, for the median
DARK = 8.0  # grey levels below which a channel says nothing


def log_chroma(bgr: np.ndarray) -> np.ndarray:
    """Return log(R/G), log(G/B), float32 (..., 2), of colours (..., 3)."""
    logs = np.log(np.maximum(bgr.astype(np.float32), 1.0))
    return np.stack([logs[..., 2] - logs[..., 1], logs[..., 1] - logs[..., 0]], axis=-1)


@dataclass(frozen=True, eq=False)
class ChromaTest:
    """Test of a reduced picture against its background.

    mean float32 (2, h, w) log chroma; noise float32 (h, w) of the smoothed picture [grey levels];
    median (2,): log chroma of the whole scene.
    """

    mean: np.ndarray
    noise: np.ndarray
    median: Floats

    @staticmethod
    def of(background: Background) -> ChromaTest:
        """Prepare the test of a reduced picture's background."""
        bgr = background.bgr
        chroma = np.ascontiguousarray(np.moveaxis(log_chroma(smoothed(bgr)), -1, 0))
        noise = np.maximum(background.sd[..., 2] * 255.0, LEAST_NOISE) * KEPT_NOISE
        return ChromaTest(
            readonly(chroma, (2, None, None), "mean", np.float32),
            readonly(noise, (None, None), "noise", np.float32),
            np.median(log_chroma(bgr).reshape(-1, 2), axis=0).astype(np.float64),
        )

    def __call__(self, small: np.ndarray) -> np.ndarray:
        """Test a reduced picture uint8 (h, w, 3): uint8 (h, w), 1 where its chroma differs.

        A pixel must differ smoothed, and a little by itself: smoothing carries a shirt's colour
        over its edge.
        """
        bgr = small.astype(np.float32)
        far = self._distance(smoothed(bgr), 1.0) > THRESHOLD
        at = np.flatnonzero(far)
        if len(at):
            far.reshape(-1)[at] = self._distance(bgr, 1.0 / KEPT_NOISE, at)[:, 0] > THRESHOLD_ALONE
        return far.astype(np.uint8)

    def _distance(self, bgr: np.ndarray, noisier: float, at: Ints | None = None) -> np.ndarray:
        """Squared Mahalanobis distance (h, w) in log chroma, 0 where a channel is dark.

        at: flat indices (n,) of the pixels that are asked for; then the result is (n, 1).
        """
        mean, noise = self.mean, self.noise
        some = _levels(bgr[::EVERY, ::EVERY])
        # What the camera's own white balance did since: most of a picture is background.
        shifts = [np.median(off) for off in _differences(some, mean[:, ::EVERY, ::EVERY])]
        if at is not None:
            bgr = bgr.reshape(-1, 1, 3).take(at, axis=0)
            mean = mean.reshape(2, -1, 1).take(at, axis=1)
            noise = noise.reshape(-1, 1).take(at, axis=0)
        levels = _levels(bgr)
        one, two = _differences(levels, mean)
        one -= shifts[0]
        two -= shifts[1]
        square = (noisier * noise) ** 2
        of_blue, of_green, of_red = (square / (level * level) for level in levels)
        distance: np.ndarray = one * one / (of_red + of_green + FLOOR**2)
        distance += two * two / (of_green + of_blue + FLOOR**2)
        distance[np.minimum.reduce(levels) <= DARK] = 0.0
        return distance


def _levels(bgr: np.ndarray) -> Sequence[np.ndarray]:
    """Split a float32 picture (h, w, 3): numpy reduces an axis of 3 slowly."""
    return cv2.split(np.maximum(bgr, 1.0))


def _differences(levels: Sequence[np.ndarray], mean: np.ndarray) -> list[np.ndarray]:
    """Log chroma, its two parts one by one, of levels B, G, R less the mean (2, ...)."""
    blue, green, red = (np.log(level) for level in levels)
    return [red - green - mean[0], green - blue - mean[1]]


def smoothed(bgr: np.ndarray) -> np.ndarray:
    """Smooth a float32 picture (h, w, 3)."""
    smooth: np.ndarray = cv2.GaussianBlur(bgr, (0, 0), SMOOTH_PX)
    return smooth
