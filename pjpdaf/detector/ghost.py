"""Ghosts: places that differ from the learnt background because something that was there is gone.

A cup that was lifted uncovers the table, and its shadow goes with it. What is seen there then looks
like the background around it, and the learnt background alone does not.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from pjpdaf.arrays import readonly
from pjpdaf.detector.background import Background

SMOOTH_PX = 0.8  # of the reduced picture
AROUND_PX = 15, 25, 35  # sides of windows whose median is what is around, of the reduced picture
SURFACE = 0.5  # share of the window that must look like its median: one surface, as a table is
OBJECT = 0.15  # of log brightness, by which a thing or its shadow differs from what is around it
LIKE = 0.12, 0.5  # from what is around: of log brightness, and as a share of the thing's own
RATHER_LIKE = 0.25, 0.75  # the same beside pixels that are LIKE it
EVERY = 3  # pixels, for the median change of light
RIM = np.ones((3, 3), np.uint8)


@dataclass(frozen=True, eq=False)
class GhostTest:
    """Test of a reduced picture for ghosts.

    around: for each window float32 (h, w, 3): logarithms of the background's BGR as it is around
    each pixel; own float32 (h, w, 3): those of the pixel itself; off: for each window float32
    (h, w): the largest difference, 0 where what is around is no one surface.
    """

    around: tuple[np.ndarray, ...]
    own: np.ndarray
    off: tuple[np.ndarray, ...]

    @staticmethod
    def of(background: Background) -> GhostTest:
        """Prepare the test of a reduced picture's background."""
        bgr = cv2.cvtColor(np.ascontiguousarray(background.mean), cv2.COLOR_HSV2BGR) * 255.0
        own = _logs(bgr)
        levels = np.rint(bgr).astype(np.uint8)
        around = tuple(_logs(cv2.medianBlur(levels, side)) for side in AROUND_PX)
        return GhostTest(
            tuple(readonly(wide, (None, None, 3), "around", np.float32) for wide in around),
            readonly(own, (None, None, 3), "own", np.float32),
            tuple(
                readonly(_off(own, wide, side), (None, None), "off", np.float32)
                for wide, side in zip(around, AROUND_PX, strict=True)
            ),
        )

    def __call__(self, small: np.ndarray) -> np.ndarray | None:
        """Find the ghosts of a reduced picture uint8 (h, w, 3): uint8 (h, w), 0 or 1, or None."""
        now = _logs(small)
        # A change of light since the background was learnt.
        change = np.median((now - self.own)[::EVERY, ::EVERY].reshape(-1, 3), axis=0)
        now -= change
        sure, ghost = (np.zeros(now.shape[:2], np.uint8) for _ in range(2))
        for around, off in zip(self.around, self.off, strict=True):
            # Channel by channel: numpy reduces an axis of 3 slowly.
            left = np.maximum.reduce([np.abs(c) for c in cv2.split(now - around)])
            thing = off > OBJECT
            sure |= thing & (left < LIKE[0]) & (left < LIKE[1] * off)
            ghost |= thing & (left < RATHER_LIKE[0]) & (left < RATHER_LIKE[1] * off)
        sure = cv2.morphologyEx(sure, cv2.MORPH_OPEN, RIM)
        _, labels = cv2.connectedComponents(ghost, connectivity=4)
        mask = np.isin(labels, np.unique(labels[sure > 0])).astype(np.uint8)
        mask &= ghost
        # Edges are mixtures of a thing and what is around it.
        return cv2.dilate(mask, RIM) if mask.any() else None


def _off(own: np.ndarray, around: np.ndarray, side: int) -> np.ndarray:
    """Differences (h, w) of pixels from what is around them, 0 where that is no one surface."""
    off = np.abs(own - around).max(axis=2)
    alike = cv2.blur((off < OBJECT).astype(np.float32), (side, side))
    return np.asarray(np.where(alike >= SURFACE, off, 0.0), np.float32)


def _logs(bgr: np.ndarray) -> np.ndarray:
    smooth = cv2.GaussianBlur(bgr.astype(np.float32), (0, 0), SMOOTH_PX)
    return np.asarray(np.log(np.maximum(smooth, 4.0)))
