"""Chroma: logarithms of ratios of the channels, and a background test that looks at them alone.

A change of light, a shadow for one, multiplies a pixel's channels and so adds a constant to its
log chroma. A smoothed picture shows differences in it that hue and saturation of single pixels hide
in their noise: a face before a wall of its own colour.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from pjpdaf.arrays import Floats, readonly
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

    mean float32 (h, w, 2) log chroma; noise float32 (h, w) of the smoothed picture [grey levels];
    median (2,): log chroma of the whole scene.
    """

    mean: np.ndarray
    noise: np.ndarray
    median: Floats

    @staticmethod
    def of(background: Background) -> ChromaTest:
        """Prepare the test of a reduced picture's background."""
        bgr = cv2.cvtColor(np.ascontiguousarray(background.mean), cv2.COLOR_HSV2BGR) * 255.0
        chroma = log_chroma(smoothed(bgr))
        noise = np.maximum(background.sd[..., 2] * 255.0, LEAST_NOISE) * KEPT_NOISE
        return ChromaTest(
            readonly(chroma, (None, None, 2), "mean", np.float32),
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
        far &= self._distance(bgr, 1.0 / KEPT_NOISE) > THRESHOLD_ALONE
        return far.astype(np.uint8)

    def _distance(self, bgr: np.ndarray, noisier: float) -> np.ndarray:
        """Squared Mahalanobis distance (h, w) in log chroma, 0 where a channel is dark."""
        # Channel by channel: numpy reduces an axis of 2 or 3 slowly.
        levels = cv2.split(np.maximum(bgr, 1.0))
        blue, green, red = levels
        of_channels = [np.log(level) for level in levels]
        one = of_channels[2] - of_channels[1] - self.mean[..., 0]
        two = of_channels[1] - of_channels[0] - self.mean[..., 1]
        for off in (one, two):
            # What the camera's own white balance did since: most of a picture is background.
            off -= np.median(off[::EVERY, ::EVERY])
        square = (noisier * self.noise) ** 2
        of_blue, of_green, of_red = (square / (level * level) for level in levels)
        distance: np.ndarray = one * one / (of_red + of_green + FLOOR**2)
        distance += two * two / (of_green + of_blue + FLOOR**2)
        distance[np.minimum(np.minimum(blue, green), red) <= DARK] = 0.0
        return distance


def smoothed(bgr: np.ndarray) -> np.ndarray:
    """Smooth a float32 picture (h, w, 3)."""
    smooth: np.ndarray = cv2.GaussianBlur(bgr, (0, 0), SMOOTH_PX)
    return smooth
