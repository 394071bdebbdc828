"""Silhouette of a person: a reduced picture of background, clothes and skin."""

from __future__ import annotations

import cv2
import numpy as np

from pjpdaf.camera import Camera
from pjpdaf.detector.background import BackgroundTest, is_foreground
from pjpdaf.detector.skin import to_hsv
from pjpdaf.looks import CLOTHED, SKIN, Silhouette

WIDTH_PX = 160  # about; the picture is reduced by a whole number
OPENING = np.ones((3, 3), np.uint8)


def reduction(width_px: int) -> int:
    """Return by how much a picture of this width is reduced."""
    return max(1, round(width_px / WIDTH_PX))


def reduced(picture: np.ndarray) -> np.ndarray:
    """Reduce a uint8 picture (h, w, 3) by averaging."""
    height, width = picture.shape[:2]
    step = reduction(width)
    size = (max(width // step, 1), max(height // step, 1))
    small: np.ndarray = cv2.resize(picture, size, interpolation=cv2.INTER_AREA)
    return small


def silhouette(
    picture: np.ndarray, skin: np.ndarray, test: BackgroundTest | None, camera: Camera
) -> Silhouette:
    """Classify a picture uint8 BGR (h, w, 3) with its accepted skin pixels uint8 (h, w).

    test: of the reduced, person-free pictures; without it nothing is CLOTHED. camera: whose lens
    is taken out of the result.
    """
    small = reduced(picture)
    height, width = small.shape[:2]
    share = cv2.resize(skin, (width, height), interpolation=cv2.INTER_AREA)
    classes = np.zeros((height, width), np.uint8)
    if test is not None:
        hsv = to_hsv(small)
        far = is_foreground(test, hsv, np.arange(height * width)).reshape(height, width)
        opened = cv2.morphologyEx(far.astype(np.uint8), cv2.MORPH_OPEN, OPENING)
        classes[opened > 0] = CLOTHED
    classes[share > 127] = SKIN
    step = reduction(picture.shape[1])
    if np.any(camera.distortion):
        classes = _undistorted(classes, step, camera)
    return Silhouette(classes, step)


def _undistorted(classes: np.ndarray, step: int, camera: Camera) -> np.ndarray:
    K = np.array(camera.K)
    K[:2] /= step
    K[:2, 2] += 0.5 / step - 0.5  # pixel centres
    size = (classes.shape[1], classes.shape[0])
    x, y = cv2.initUndistortRectifyMap(
        K, np.array(camera.distortion), np.eye(3), K, size, cv2.CV_32FC1
    )
    ideal: np.ndarray = cv2.remap(classes, x, y, cv2.INTER_NEAREST)
    return ideal
