"""A background from the footage itself: at each pixel, what is seen most of the time."""

from __future__ import annotations

from collections.abc import Iterable

import cv2
import numpy as np

from pjpdaf.errors import BenchError
from pjpdaf.frames import StereoFrame
from sim.randomness import generator

MOST_BYTES = 200 << 20  # of the pictures that are held, of each view
MOST_FRAMES, LEAST_FRAMES = 60, 20  # spread over the footage
LEARNT = 12  # frames made of the median and the noise
CHANGE_PER_SD = 0.954  # median |x - y| of two values with Gaussian noise, over its deviation
STILL_LEVELS = 12  # grey levels: a pixel that changes less is still
_SKIN_HSV = ((0, 51, 51), (25, 217, 255))  # of any person, in OpenCV's half degrees


def usual_frames(
    frames: Iterable[StereoFrame], total: int | None
) -> tuple[list[StereoFrame], float]:
    """Person-free frames made of each pixel's median over time, and of its noise.

    frames: the footage; total: their number, None if unknown. A person who moves covers a pixel
    for less than half of the time. Returns the frames, and the share of the skin-coloured pixels of
    the median that hardly change: what rests would be learnt away. Raises BenchError for less than
    LEAST_FRAMES pictures in a view.
    """
    views: list[list[np.ndarray]] = []
    step = max(1, (total or 0) // MOST_FRAMES)
    for number, frame in enumerate(frames):
        views = views or [[] for _ in frame.pictures]
        if number % step:
            continue
        for held, picture in zip(views, frame.pictures, strict=True):
            if picture is not None:
                held.append(picture)
        if any(_are_too_many(held) for held in views):
            step *= 2
            views = [held[::2] for held in views]
    fewest = min((len(held) for held in views), default=0)
    if fewest < LEAST_FRAMES:
        raise BenchError(
            f"--background-from-footage needs at least {LEAST_FRAMES} pictures of each view, got "
            f"{fewest}."
        )
    usual, still = zip(*(_usual(held, view) for view, held in enumerate(views)), strict=True)
    learnt = [StereoFrame(k, float(k), tuple(view[k] for view in usual)) for k in range(LEARNT)]
    return learnt, float(np.mean(still))


def _are_too_many(held: list[np.ndarray]) -> bool:
    return len(held) > 2 * MOST_FRAMES or sum(p.nbytes for p in held) > MOST_BYTES


def _usual(pictures: list[np.ndarray], view: int) -> tuple[np.ndarray, float]:
    """LEARNT pictures (LEARNT, h, w, 3): each pixel's median over time, with the footage's noise.

    And the share of the median's skin colour that is still. In bands of rows: a sorted copy of all
    pictures at once would double the memory.
    """
    rng = generator(view, "footage/usual_scene")
    shape = pictures[0].shape
    learnt, spread = np.empty((LEARNT, *shape), np.uint8), np.empty(shape, np.uint8)
    for top in range(0, shape[0], 32):
        rows = slice(top, top + 32)
        band = np.stack([picture[rows] for picture in pictures])
        # Differences from picture to picture: what moves is in less than half of them.
        changes = np.abs(np.diff(band.astype(np.int16), axis=0))
        noise = np.maximum(np.median(changes, axis=0) / CHANGE_PER_SD, 0.5)
        band.sort(axis=0)
        median = band[len(band) // 2]
        noisy = median + noise * rng.standard_normal((LEARNT, *median.shape))
        learnt[:, rows] = np.clip(np.round(noisy), 0, 255).astype(np.uint8)
        low, high = (band[round(share * (len(band) - 1))] for share in (0.1, 0.9))
        spread[rows] = high - low
    mean = learnt.mean(axis=0).astype(np.uint8)
    skin = cv2.inRange(cv2.cvtColor(mean, cv2.COLOR_BGR2HSV), *_SKIN_HSV) > 0
    quiet = spread.max(axis=2) < STILL_LEVELS
    return learnt, float(quiet[skin].mean()) if skin.any() else 0.0
