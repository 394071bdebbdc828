"""A part of one view with truth and estimates, a red line from each wrong estimate to its truth."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Floats, Image
from reports.pictures.overlay import (
    BLACK,
    LETTERS,
    Colour,
    draw_cross,
    draw_curve,
    draw_text,
    ellipse_points,
    fixed,
)
from reports.pictures.overlay import SHIFT as SHIFT_BITS

TILE_PX = (320, 240)
WRONG_M = 0.10  # of an estimate from its own truth; `player_marks.js` has the same bound
# BGR, the bright ones of the page's player: the scenes are dark.
TARGET_COLOURS: tuple[Colour, ...] = ((94, 143, 255), (160, 220, 63), (255, 189, 116))
RED: Colour = (46, 46, 235)
_RADIUS_PX = 11.0


@dataclass(frozen=True)
class Crop:
    """A part of a view [its px], of the shape of a tile."""

    x: float
    y: float
    width: float

    @property
    def height(self) -> float:
        """Its height."""
        return self.width * TILE_PX[1] / TILE_PX[0]


def crop_about(points_px: Floats, size_px: tuple[int, int], margin_px: float = 70.0) -> Crop:
    """The part of a view of this width and height about pixels (n, 2); NaN and outside ignored."""
    width, height = size_px
    shape = TILE_PX[0] / TILE_PX[1]
    most = min(width, height * shape)
    inside = np.isfinite(points_px).all(axis=1)
    inside &= (np.nan_to_num(points_px) >= 0).all(axis=1)
    inside &= (np.nan_to_num(points_px) < [width, height]).all(axis=1)
    if not inside.any():
        return Crop(0.0, 0.0, most)
    low, high = points_px[inside].min(axis=0), points_px[inside].max(axis=0)
    span = high - low + 2 * margin_px
    wide = float(min(most, max(span[0], span[1] * shape, 0.4 * most)))
    middle = (low + high) / 2
    x = float(np.clip(middle[0] - wide / 2, 0, width - wide))
    y = float(np.clip(middle[1] - wide / shape / 2, 0, height - wide / shape))
    return Crop(x, y, wide)


def marked_tile(
    view: Image,
    crop: Crop,
    width_px: int,
    truth_px: Floats,
    estimates_px: Floats,
    wrong: NDArray[np.bool_],
    tracked: NDArray[np.bool_],
) -> Image:
    """Draw a tile (h, w, 3) BGR of a view.

    view: the picture, of any size, of a view that is width_px wide; truth_px, estimates_px (T, 2)
    in the view's pixels, NaN where there is none; wrong (T,): these get the red line; tracked
    (T,): others are drawn thin. Truth: crosses. Estimates: circle, square, diamond with a letter.
    """
    scale = view.shape[1] / width_px
    x0, y0 = (round(v * scale) for v in (crop.x, crop.y))
    x1, y1 = (round(v * scale) for v in (crop.x + crop.width, crop.y + crop.height))
    canvas = np.asarray(
        cv2.resize(view[y0:y1, x0:x1], TILE_PX, interpolation=cv2.INTER_LINEAR), dtype=np.uint8
    )

    def at(points: Floats) -> Floats:
        return np.asarray((points + 0.5 - [crop.x, crop.y]) * (TILE_PX[0] / crop.width))

    truth, estimates = at(truth_px), at(estimates_px)
    shown = np.isfinite(truth).all(axis=1) & np.isfinite(estimates).all(axis=1)
    for t in np.flatnonzero(wrong & shown).tolist():
        ends = fixed(estimates[t]), fixed(truth[t])
        for thickness, colour in ((7, BLACK), (4, RED)):
            cv2.line(canvas, *ends, colour, thickness, cv2.LINE_AA, SHIFT_BITS)
    for t, colour in enumerate(TARGET_COLOURS):
        if np.isfinite(truth[t]).all():
            draw_cross(canvas, truth[t], colour)
    for t, colour in enumerate(TARGET_COLOURS):
        if not np.isfinite(estimates[t]).all():
            continue
        draw_curve(canvas, estimates[t] + _outline(t), colour, 2 if tracked[t] else 1)
        if (estimates[t] > 0).all() and (estimates[t] < TILE_PX).all():
            x = min(int(estimates[t, 0]) + 13, TILE_PX[0] - 14)
            draw_text(canvas, LETTERS[t], (x, max(int(estimates[t, 1]) - 8, 14)), colour, 0.5)
    return canvas


def _outline(target: int) -> Floats:
    """Circle, square and diamond about the origin, as the page's player draws them."""
    r = _RADIUS_PX
    if target == 0:
        return ellipse_points(np.zeros(2), r, r, 0.0)
    if target == 1:
        s = 0.88 * r
        return np.array([[-s, -s], [s, -s], [s, s], [-s, s]])
    d = 1.2 * r
    return np.array([[0, -d], [d, 0], [0, d], [-d, 0]])
