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
HEAD_SHARE = 0.08  # of the picture: a head is no larger
_SKIN_HSV = ((0, 51, 51), (25, 217, 255))  # of any person, in OpenCV's half degrees


def usual_frames(frames: Iterable[StereoFrame], total: int | None) -> tuple[list[StereoFrame], int]:
    """Person-free frames made of each pixel's median over time, and of its noise.

    frames: the footage; total: their number, None if unknown. A person who moves covers a pixel
    for less than half of the time. Parts of the median that are of the colour of skin, no larger
    than a head and inside the picture are the person's, who rests: they become something else, so
    that skin is found there. Returns the frames, and the number of these parts in all views. Raises
    BenchError for less than LEAST_FRAMES pictures in a view.
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
    usual, parts = zip(*(_usual(held, view) for view, held in enumerate(views)), strict=True)
    learnt = [StereoFrame(k, float(k), tuple(view[k] for view in usual)) for k in range(LEARNT)]
    return learnt, sum(parts)


def _are_too_many(held: list[np.ndarray]) -> bool:
    return len(held) > 2 * MOST_FRAMES or sum(p.nbytes for p in held) > MOST_BYTES


def _usual(pictures: list[np.ndarray], view: int) -> tuple[np.ndarray, int]:
    """LEARNT pictures (LEARNT, h, w, 3) of the usual scene, and the number of resting parts.

    In bands of rows: a sorted copy of all pictures at once would double the memory.
    """
    rng = generator(view, "footage/usual_scene")
    shape = pictures[0].shape
    learnt = np.empty((LEARNT, *shape), np.uint8)
    for top in range(0, shape[0], 32):
        rows = slice(top, top + 32)
        band = np.stack([picture[rows] for picture in pictures])
        # Differences from picture to picture: what moves is in less than half of them.
        changes = np.abs(np.diff(band.astype(np.int16), axis=0))
        noise = np.maximum(np.median(changes, axis=0) / CHANGE_PER_SD, 0.5)
        median = np.median(band, axis=0)
        noisy = median + noise * rng.standard_normal((LEARNT, *median.shape))
        learnt[:, rows] = np.clip(np.round(noisy), 0, 255).astype(np.uint8)
    resting, count = _resting_parts(learnt.mean(axis=0).astype(np.uint8))
    learnt[:, resting] = 255 - learnt[:, resting]
    return learnt, count


def _resting_parts(picture: np.ndarray) -> tuple[np.ndarray, int]:
    """Mask (h, w) and number of skin-coloured parts as small as a head, inside the picture."""
    skin = cv2.inRange(cv2.cvtColor(picture, cv2.COLOR_BGR2HSV), *_SKIN_HSV)
    skin = cv2.morphologyEx(skin, cv2.MORPH_OPEN, np.ones((5, 5), np.uint8))
    count, labels, stats, _ = cv2.connectedComponentsWithStats(skin, connectivity=8)
    height, width = skin.shape
    resting = np.zeros(skin.shape, bool)
    parts = 0
    for k in range(1, count):
        x, y, w, h, area = stats[k].tolist()
        inside = x > 0 and y > 0 and x + w < width and y + h < height
        if inside and area <= HEAD_SHARE * skin.size:
            resting |= labels == k
            parts += 1
    wide = cv2.dilate(resting.astype(np.uint8), np.ones((15, 15), np.uint8))
    return wide > 0, parts
