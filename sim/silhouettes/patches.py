"""Patches of the targets in a painted picture: area, centre, second moments, box."""

from __future__ import annotations

from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from pjpdaf.targets import TARGETS
from sim.silhouettes.shapes import TARGET_PAINT

Box = tuple[int, int, int, int]  # left, top, right, bottom; right and bottom are outside


class Patch(NamedTuple):
    """The visible pixels of a target: how many, their mean, their second central moments, their
    box, and in how many pieces they are; in pixels of the painted picture.
    """

    pixels: int
    x: float
    y: float
    xx: float
    xy: float
    yy: float
    box: Box
    pieces: int


def patch_of(classes: NDArray[np.uint8], target: int, within: Box, covered: bool) -> Patch | None:
    """The patch of a target, None where nothing of it is visible.

    within: a box that holds it; covered: something may lie over it, so that it may be in pieces.
    """
    left, top, right, bottom = within
    if left >= right or top >= bottom:
        return None
    mask = (classes[top:bottom, left:right] == TARGET_PAINT + target).view(np.uint8)
    # Not as a binary image, which takes twice as long; the central moments, whose last bit then
    # depends on the library's build, are OpenCV's own sums of the spatial ones, which are whole.
    sums = cv2.moments(mask)
    n, m10, m01 = sums["m00"], sums["m10"], sums["m01"]
    if n == 0:
        return None
    one = 1.0 / n
    x, y, width, height = cv2.boundingRect(mask)
    pieces = cv2.connectedComponents(mask)[0] - 1 if covered else 1
    return Patch(
        int(n),
        m10 / n + left,
        m01 / n + top,
        (sums["m20"] - m10 * (m10 * one)) / n,
        (sums["m11"] - m10 * (m01 * one)) / n,
        (sums["m02"] - m01 * (m01 * one)) / n,
        (left + x, top + y, left + x + width, top + y + height),
        pieces,
    )


def apart(a: Box, b: Box, gap: int) -> bool:
    """Whether at least gap + 1 columns or rows lie between two boxes."""
    return a[0] > b[2] + gap or b[0] > a[2] + gap or a[1] > b[3] + gap or b[1] > a[3] + gap


Patches = tuple[Patch | None, ...]
T = len(TARGETS)
