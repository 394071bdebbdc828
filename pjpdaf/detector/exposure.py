"""Noise of a view's pictures, as its background frames show it, and the blur that takes it out."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

NOISY = 0.045  # noise over brightness above which colour tests of single pixels fail
AIM = 0.030  # noise over brightness after the blur
BLUR_MAX_PX = 3.0  # a hand's fingers are 8 px wide
STEP_PX = 3  # every third pixel is enough


@dataclass(frozen=True)
class Exposure:
    """Smoothing of a view's pictures. blur_px: deviation of the Gaussian [px], 0 = none."""

    blur_px: float = 0.0

    def __call__(self, picture: np.ndarray) -> np.ndarray:
        """Return the picture uint8 (h, w, 3) smoothed, or itself without a blur."""
        if self.blur_px == 0.0:
            return picture
        smooth: np.ndarray = cv2.GaussianBlur(picture, (0, 0), self.blur_px)
        return smooth


def exposure_of(pictures: Sequence[np.ndarray]) -> Exposure:
    """Choose the blur from person-free pictures uint8 (h, w, 3) of one view; none from under two.

    Noise is the deviation of a pixel between successive pictures; steps of the whole picture's
    brightness (flicker) do not count. A Gaussian of deviation s averages 4 pi s^2 pixels.
    """
    if len(pictures) < 2:
        return Exposure()
    sampled = [p[::STEP_PX, ::STEP_PX].astype(np.float32) for p in pictures]
    variances = []
    for one, two in itertools.pairwise(sampled):
        off = two - one
        off -= np.median(off)
        square = off * off
        variances.append(float(np.mean(square[square <= np.percentile(square, 99)])) / 2.0)
    noise = math.sqrt(float(np.median(variances)) * 1.1)  # the 1 % cut off had a tenth of it
    brightness = float(np.median(sampled[0].max(axis=2)))
    ratio = noise / max(brightness, 1.0)
    if ratio <= NOISY:
        return Exposure()
    return Exposure(min(ratio / AIM / math.sqrt(4.0 * math.pi), BLUR_MAX_PX))
