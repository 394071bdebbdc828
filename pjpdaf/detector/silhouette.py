"""Silhouette: a small picture of what is background, clothed person, and skin."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from pjpdaf.detector.background import BackgroundTest, is_foreground
from pjpdaf.detector.skin import to_hsv

BACKGROUND, CLOTHED, SKIN = 0, 1, 2  # values of a silhouette's pixels
WIDTH_PX = 160  # about; the picture is reduced by a whole number
OPENING = np.ones((3, 3), np.uint8)


@dataclass(frozen=True, eq=False)
class Silhouette:
    """What each pixel of a reduced picture shows.

    classes uint8 (h, w): BACKGROUND, CLOTHED or SKIN, undistorted; step_px: size of one of its
    pixels in pixels of the picture, so pixel (x, y) of the picture is (x / step, y / step) here,
    both counted from the corner of the picture.
    """

    classes: np.ndarray
    step_px: int


def reduction(width_px: int) -> int:
    """By how much a picture of this width is reduced."""
    return max(1, round(width_px / WIDTH_PX))


def reduced(picture: np.ndarray) -> np.ndarray:
    """A uint8 picture (h, w, 3) reduced by averaging."""
    height, width = picture.shape[:2]
    step = reduction(width)
    small: np.ndarray = cv2.resize(
        picture, (width // step, height // step), interpolation=cv2.INTER_AREA
    )
    return small


def silhouette(picture: np.ndarray, skin: np.ndarray, test: BackgroundTest | None) -> Silhouette:
    """Silhouette of a picture uint8 BGR (h, w, 3) with its accepted skin pixels (h, w).

    test: of the reduced, person-free pictures; without one nothing is CLOTHED.
    """
    small = reduced(picture)
    height, width = small.shape[:2]
    share = cv2.resize(skin, (width, height), interpolation=cv2.INTER_AREA)
    classes = np.zeros((height, width), np.uint8)
    if test is not None:
        hsv = to_hsv(small)
        far = is_foreground(test, hsv, np.arange(height * width)).reshape(height, width)
        classes = cv2.morphologyEx(far.astype(np.uint8), cv2.MORPH_OPEN, OPENING)
    classes[share > 127] = SKIN
    return Silhouette(classes, reduction(picture.shape[1]))
