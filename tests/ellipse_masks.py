"""Masks of drawn ellipses, for the tests of the detector."""

from __future__ import annotations

import math

import numpy as np

SIZE = (480, 640)
Ellipse = tuple[float, float, float, float, float]  # centre x, y, semi-axes a, b, angle [rad]
HEAD = (310.3, 105.6, 45.0, 34.0, 1.5)
HANDS = ((150.2, 330.9, 27.0, 17.0, 0.6), (470.7, 345.1, 24.0, 16.0, -0.9))


def drawn(*ellipses: Ellipse, size: tuple[int, int] = SIZE) -> np.ndarray:
    """Mask with the pixels whose centres lie in an ellipse: exact, unlike cv2.ellipse."""
    y, x = np.mgrid[0 : size[0], 0 : size[1]]
    mask = np.zeros(size, bool)
    for cx, cy, a, b, angle in ellipses:
        u = (x - cx) * math.cos(angle) + (y - cy) * math.sin(angle)
        v = -(x - cx) * math.sin(angle) + (y - cy) * math.cos(angle)
        mask |= (u / a) ** 2 + (v / b) ** 2 <= 1
    return mask.astype(np.uint8) * 255
