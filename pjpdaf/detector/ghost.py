"""Ghosts: places that differ from the learnt background because something that was there is gone.

A cup that was lifted uncovers the table, and its shadow goes with it. What is seen there then looks
like the background around it, and the learnt background alone does not.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np

from pjpdaf.arrays import readonly
from pjpdaf.detector.background import Background
from pjpdaf.detector.chroma import smoothed

AROUND_PX = 15, 25, 35  # sides of windows whose median is what is around, of the reduced picture
SURFACE = 0.5  # share of the window that must look like its median: one surface, as a table is
OBJECT = 0.15  # of log brightness, by which a thing or its shadow differs from what is around it
LIKE = 0.12, 0.5  # from what is around: of log brightness, and as a share of the thing's own
RATHER_LIKE = 0.25, 0.75  # the same beside pixels that are LIKE it
EVERY = 3  # pixels, for the median change of light
RIM = np.ones((3, 3), np.uint8)


class Surroundings(NamedTuple):
    """Pixels of things, flat indices (n,), which differ from what is around them.

    around float32 (3, n): logarithms of the background's BGR there; off float32 (n,): the pixels'
    largest differences from it.
    """

    at: np.ndarray
    around: np.ndarray
    off: np.ndarray

    @staticmethod
    def of(own: np.ndarray, around: np.ndarray, side: int) -> Surroundings:
        """Choose the pixels of log pictures (h, w, 3); side: of the window [px]."""
        off = _off(own, around, side).reshape(-1)
        at = np.flatnonzero(off > OBJECT)
        return Surroundings(at, np.ascontiguousarray(around.reshape(-1, 3)[at].T), off[at])


@dataclass(frozen=True, eq=False)
class GhostTest:
    """Test of a reduced picture for ghosts.

    own float32 (h, w, 3): logarithms of the background's BGR; windows: what is around its things,
    for windows of several sizes.
    """

    own: np.ndarray
    windows: tuple[Surroundings, ...]

    @staticmethod
    def of(background: Background) -> GhostTest:
        """Prepare the test of a reduced picture's background."""
        bgr = background.bgr
        own = _logs(bgr)
        levels = np.rint(bgr).astype(np.uint8)
        return GhostTest(
            readonly(own, (None, None, 3), "own", np.float32),
            tuple(
                Surroundings.of(own, _logs(cv2.medianBlur(levels, side)), side)
                for side in AROUND_PX
            ),
        )

    def __call__(self, small: np.ndarray) -> np.ndarray | None:
        """Find the ghosts of a reduced picture uint8 (h, w, 3): uint8 (h, w), 0 or 1, or None."""
        now = _logs(small)
        # A change of light since the background was learnt. Channel by channel, here and below:
        # numpy reduces an axis of 3 slowly.
        change = [float(np.median(c)) for c in cv2.split((now - self.own)[::EVERY, ::EVERY])]
        sure, ghost = (np.zeros(now.shape[:2], np.uint8) for _ in range(2))
        for at, around, off in self.windows:
            levels = now.reshape(-1, 3).take(at, axis=0).T
            left = np.maximum.reduce(
                [np.abs(c - d - wide) for c, d, wide in zip(levels, change, around, strict=True)]
            )
            sure.reshape(-1)[at] |= (left < LIKE[0]) & (left < LIKE[1] * off)
            ghost.reshape(-1)[at] |= (left < RATHER_LIKE[0]) & (left < RATHER_LIKE[1] * off)
        sure = cv2.morphologyEx(sure, cv2.MORPH_OPEN, RIM)
        if not sure.any():
            return None
        _, labels = cv2.connectedComponents(ghost, connectivity=4)
        mask = np.isin(labels, np.unique(labels[sure > 0])).astype(np.uint8)
        mask &= ghost
        # Edges are mixtures of a thing and what is around it.
        return np.asarray(cv2.dilate(mask, RIM))


def _off(own: np.ndarray, around: np.ndarray, side: int) -> np.ndarray:
    """Differences (h, w) of pixels from what is around them, 0 where that is no one surface."""
    off = np.abs(own - around).max(axis=2)
    alike = cv2.blur((off < OBJECT).astype(np.float32), (side, side))
    return np.asarray(np.where(alike >= SURFACE, off, 0.0), np.float32)


def _logs(bgr: np.ndarray) -> np.ndarray:
    return np.asarray(np.log(np.maximum(smoothed(bgr.astype(np.float32)), 4.0)))
