"""A reduced picture with what several tests take of it, computed once."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import cv2
import numpy as np

from pjpdaf.detector.skin import to_hsv

SMOOTH_PX = 0.8


class SmallPicture(NamedTuple):
    """A reduced picture, uint8 BGR (h, w, 3), and the same as of `to_hsv`.

    levels: blue, green and red of the smoothed picture, float32 (h, w) each, 1 where they are less;
    logs: their logarithms.
    """

    bgr: np.ndarray
    hsv: np.ndarray
    levels: Sequence[np.ndarray]
    logs: Sequence[np.ndarray]

    @staticmethod
    def of(bgr: np.ndarray) -> SmallPicture:
        """Prepare a reduced picture."""
        levels = smooth_levels(bgr.astype(np.float32))
        return SmallPicture(bgr, to_hsv(bgr), levels, [np.log(level) for level in levels])


def smooth_levels(bgr: np.ndarray) -> Sequence[np.ndarray]:
    """Smooth a float32 picture (h, w, 3): its channels (h, w), 1 where they are less.

    Channels of their own: numpy works slowly along an axis of 3.
    """
    return cv2.split(np.maximum(cv2.GaussianBlur(bgr, (0, 0), SMOOTH_PX), 1.0))
