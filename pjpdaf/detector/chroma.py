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

from pjpdaf.arrays import Floats, Ints, median, readonly
from pjpdaf.detector.background import Background
from pjpdaf.detector.small_picture import SMOOTH_PX, SmallPicture, smooth_levels

KEPT_NOISE = 1.0 / (4.0 * np.pi * SMOOTH_PX**2) ** 0.5  # share of the noise that smoothing leaves
LEAST_NOISE = 0.7  # of a pixel of the reduced picture [grey levels]
FLOOR = 0.011  # deviation of log chroma that light itself makes
THRESHOLD = 18.4  # 99.99 % point of chi-square with 2 degrees of freedom
THRESHOLD_ALONE = 8.0  # of a pixel that was not smoothed
# Square of a difference in log chroma that is far enough without noise, with room for rounding.
NEAREST = 0.99 * THRESHOLD * FLOOR**2
# Pixels, for the median: what the camera's own white balance did since. Most of a picture is
# background.
EVERY = 3
DARK = 8.0  # grey levels below which a channel says nothing
LEVELS = np.maximum(np.arange(256, dtype=np.float32), 1.0)
LOGS = np.log(LEVELS)


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
        blue, green, red = (np.log(level) for level in smooth_levels(bgr))
        noise = np.maximum(background.sd[..., 2] * 255.0, LEAST_NOISE) * KEPT_NOISE
        return ChromaTest(
            readonly([red - green, green - blue], (2, None, None), "mean", np.float32),
            readonly(noise, (None, None), "noise", np.float32),
            np.median(log_chroma(bgr).reshape(-1, 2), axis=0).astype(np.float64),
        )

    def __call__(self, small: SmallPicture) -> np.ndarray:
        """Test a reduced picture (h, w): uint8 (h, w), 1 where its chroma differs.

        A pixel must differ smoothed, and a little by itself: smoothing carries a shirt's colour
        over its edge.
        """
        one, two = _differences(small.logs, self.mean)
        one -= median(one[::EVERY, ::EVERY])
        two -= median(two[::EVERY, ::EVERY])
        at = np.flatnonzero(one * one + two * two > NEAREST)
        levels = [level.take(at) for level in small.levels]
        at = at[self._distance((one.take(at), two.take(at)), levels, 1.0, at) > THRESHOLD]
        far = np.zeros(one.shape, np.uint8)
        far.reshape(-1)[at] = self._alone(small.bgr, at) > THRESHOLD_ALONE
        return far

    def _alone(self, bgr: np.ndarray, at: Ints) -> np.ndarray:
        """Squared distance (n,) of the pixels `at` (n,) of a picture uint8 that is not smoothed."""
        if not len(at):
            return np.zeros(0, np.float32)
        some = cv2.split(cv2.LUT(bgr[::EVERY, ::EVERY], LOGS))
        levels = np.ascontiguousarray(bgr.reshape(-1, 3).take(at, axis=0).T)
        off = _differences(cv2.LUT(levels, LOGS), self.mean.reshape(2, -1).take(at, axis=1))
        off_some = _differences(some, self.mean[:, ::EVERY, ::EVERY])
        off = [part - median(of_some) for part, of_some in zip(off, off_some, strict=True)]
        return self._distance(off, list(cv2.LUT(levels, LEVELS)), 1.0 / KEPT_NOISE, at)

    def _distance(
        self, off: Sequence[np.ndarray], levels: Sequence[np.ndarray], noisier: float, at: Ints
    ) -> np.ndarray:
        """Squared Mahalanobis distance (n,) in log chroma, 0 where a channel is dark.

        off: the two differences from the mean; levels: of the channels; at: flat indices of the
        pixels, (n,) each.
        """
        one, two = off
        square = (noisier * self.noise.take(at)) ** 2
        of_blue, of_green, of_red = (square / (level * level) for level in levels)
        distance: np.ndarray = one * one / (of_red + of_green + FLOOR**2)
        distance += two * two / (of_green + of_blue + FLOOR**2)
        distance[np.minimum.reduce(levels) <= DARK] = 0.0
        return distance


def _differences(logs: Sequence[np.ndarray], mean: np.ndarray) -> list[np.ndarray]:
    """Log chroma, its two parts one by one, of logarithms of B, G, R less the mean (2, ...)."""
    blue, green, red = logs
    return [red - green - mean[0], green - blue - mean[1]]
