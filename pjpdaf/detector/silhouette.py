"""Silhouette of a person: a reduced picture of background, clothes and skin."""

from __future__ import annotations

import cv2
import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.camera import Camera
from pjpdaf.detector.background import BackgroundTest, is_foreground
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
    if step == 4 and (4 * size[0], 4 * size[1]) == (width, height):
        # The same bits, faster: halved twice, exactly, in 16 bits, and rounded at the end.
        sixteenths = np.multiply(picture, np.uint16(16), dtype=np.uint16)
        half = cv2.resize(sixteenths, (width // 2, height // 2), interpolation=cv2.INTER_AREA)
        means = cv2.resize(half, size, interpolation=cv2.INTER_AREA)
        return np.asarray(cv2.convertScaleAbs(means, alpha=1 / 16))
    small: np.ndarray = cv2.resize(picture, size, interpolation=cv2.INTER_AREA)
    return small


def foreground(hsv: np.ndarray, test: BackgroundTest) -> np.ndarray:
    """Return what is unlike the background in a reduced picture, opened: uint8 (h, w), 0 or 1.

    hsv: uint8 (h, w, 3) as of `to_hsv`; test: of the reduced, person-free pictures.
    """
    height, width = hsv.shape[:2]
    far = is_foreground(test, hsv).reshape(height, width)
    return opened(far.astype(np.uint8))


def opened(mask: np.ndarray) -> np.ndarray:
    """Open a mask uint8 (h, w) of a reduced picture: specks go."""
    kept: np.ndarray = cv2.morphologyEx(mask, cv2.MORPH_OPEN, OPENING)
    return kept


def silhouette(person: np.ndarray | None, skin: np.ndarray, camera: Camera) -> Silhouette:
    """Classify the reduced picture: person as of `foreground`, skin uint8 (h, w) of the picture.

    Without a person nothing is CLOTHED. camera: whose lens is taken out of the result.
    """
    step = reduction(skin.shape[1])
    width, height = max(skin.shape[1] // step, 1), max(skin.shape[0] // step, 1)
    classes = np.zeros((height, width), np.uint8)
    if person is not None:
        classes[person > 0] = CLOTHED
    window, share = _shares(skin, step, (width, height))
    classes[window][share > 127] = SKIN
    if np.any(camera.distortion):
        classes = _undistorted(classes, step, camera)
    return Silhouette(classes, step)


def _shares(
    mask: np.ndarray, step: int, size: tuple[int, int]
) -> tuple[tuple[slice, slice], np.ndarray]:
    """Means of a mask reduced to a size (width, height), and the rows and columns that they are of.

    They are 0 elsewhere.
    """
    x, y, width, height = cv2.boundingRect(mask)
    if width == 0 or mask.shape != (size[1] * step, size[0] * step):
        return (slice(None), slice(None)), cv2.resize(mask, size, interpolation=cv2.INTER_AREA)
    left, right = x // step, -(-(x + width) // step)
    top, bottom = y // step, -(-(y + height) // step)
    block = mask[top * step : bottom * step, left * step : right * step]
    share = cv2.resize(block, (right - left, bottom - top), interpolation=cv2.INTER_AREA)
    return (slice(top, bottom), slice(left, right)), share


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


def turned(shape: Silhouette, homography: Floats) -> Silhouette:
    """Return the silhouette where pixels of the whole picture are moved by a homography (3, 3)."""
    step = shape.step_px
    reduce = np.array([[1 / step, 0, 0.5 / step - 0.5], [0, 1 / step, 0.5 / step - 0.5], [0, 0, 1]])
    H = reduce @ homography @ np.linalg.inv(reduce)
    size = (shape.classes.shape[1], shape.classes.shape[0])
    classes = cv2.warpPerspective(shape.classes, H, size, flags=cv2.INTER_NEAREST)
    return Silhouette(np.asarray(classes), step)
