"""Ghosts: places that differ from the learnt background because something that was there is gone.

A cup that was lifted uncovers the table, and its shadow goes with it. What is seen there then looks
like the background around it, and the learnt background alone does not.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np

from pjpdaf.arrays import median, readonly
from pjpdaf.detector.background import Background
from pjpdaf.detector.small_picture import SmallPicture, smooth_levels

AROUND_PX = 15, 25, 35  # sides of windows whose median is what is around, of the reduced picture
SURFACE = 0.5  # share of the window that must look like its median: one surface, as a table is
OBJECT = 0.15  # of log brightness, by which a thing or its shadow differs from what is around it
LIKE = 0.12, 0.5  # from what is around: of log brightness, and as a share of the thing's own
RATHER_LIKE = 0.25, 0.75  # the same beside pixels that are LIKE it
EVERY = 3  # pixels, for the median change of light
DARKEST = np.log(np.float32(4.0))  # levels below 4 say nothing
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
        """Choose the pixels of log pictures (3, h, w); side: of the window [px]."""
        off = _off(own, around, side).reshape(-1)
        at = np.flatnonzero(off > OBJECT)
        return Surroundings(at, around.reshape(3, -1).take(at, axis=1), off[at])


@dataclass(frozen=True, eq=False)
class GhostTest:
    """Test of a reduced picture for ghosts.

    own float32 (3, h, w): logarithms of the background's BGR; things: with what is around them, for
    windows of several sizes one after the other.
    """

    own: np.ndarray
    things: Surroundings

    @staticmethod
    def of(background: Background) -> GhostTest:
        """Prepare the test of a reduced picture's background."""
        bgr = background.bgr
        own = _log_levels(bgr)
        levels = np.rint(bgr).astype(np.uint8)
        windows = [
            Surroundings.of(own, _log_levels(cv2.medianBlur(levels, side)), side)
            for side in AROUND_PX
        ]
        return GhostTest(
            readonly(own, (3, None, None), "own", np.float32),
            Surroundings(*(np.concatenate(parts, axis=-1) for parts in zip(*windows, strict=True))),
        )

    def __call__(self, small: SmallPicture) -> np.ndarray | None:
        """Find the ghosts of a reduced picture (h, w): uint8 (h, w), 0 or 1, or None."""
        # A change of light since the background was learnt.
        change = [
            float(
                median(np.maximum(log[::EVERY, ::EVERY], DARKEST) - own[::EVERY, ::EVERY]),
            )
            for log, own in zip(small.logs, self.own, strict=True)
        ]
        at, around, off = self.things
        left = np.maximum.reduce(
            [
                np.abs(np.maximum(log.take(at), DARKEST) - d - wide)
                for log, d, wide in zip(small.logs, change, around, strict=True)
            ]
        )
        sure, ghost = (np.zeros(small.logs[0].shape, np.uint8) for _ in range(2))
        sure.reshape(-1)[at[(left < LIKE[0]) & (left < LIKE[1] * off)]] = 1
        sure = cv2.morphologyEx(sure, cv2.MORPH_OPEN, RIM)
        if not sure.any():
            return None
        ghost.reshape(-1)[at[(left < RATHER_LIKE[0]) & (left < RATHER_LIKE[1] * off)]] = 1
        count, labels = cv2.connectedComponents(ghost, connectivity=4)
        kept = np.zeros(count, np.uint8)
        kept[labels[sure > 0]] = 1
        # Edges are mixtures of a thing and what is around it.
        return np.asarray(cv2.dilate(kept.take(labels) & ghost, RIM))


def _off(own: np.ndarray, around: np.ndarray, side: int) -> np.ndarray:
    """Differences (h, w) of pixels from what is around them, 0 where that is no one surface."""
    off = np.abs(own - around).max(axis=0)
    alike = cv2.blur((off < OBJECT).astype(np.float32), (side, side))
    return np.asarray(np.where(alike >= SURFACE, off, 0.0), np.float32)


def _log_levels(bgr: np.ndarray) -> np.ndarray:
    """Logarithms (3, h, w) of the levels of a picture (h, w, 3), smoothed."""
    levels = smooth_levels(bgr.astype(np.float32))
    return np.array([np.maximum(np.log(level), DARKEST) for level in levels])
