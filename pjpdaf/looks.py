"""Looks of a view's blobs beyond their ellipses: silhouette, pixels, direction of fingers."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from pjpdaf.arrays import Floats, Ints

BACKGROUND, CLOTHED, SKIN = 0, 1, 2  # classes of a silhouette's pixels


@dataclass(frozen=True, eq=False)
class Silhouette:
    """Classes of the pixels of a reduced picture.

    classes uint8 (h, w): BACKGROUND, CLOTHED or SKIN, undistorted; step_px: size of one of its
    pixels in pixels of the picture, so that pixel x of the picture is (x + 0.5) / step_px - 0.5
    here.
    """

    classes: np.ndarray
    step_px: int


@dataclass(frozen=True, eq=False)
class BlobLooks:
    """Looks of the n blobs of a view.

    pixels: of each blob (k, 2), undistorted, on a lattice; each stands for pixel_area_px pixels.
    palms (n, 2): of each blob from the middle of its widest part, the palm, to its centroid;
    fingers (n, 2): the share that its thin parts have in that vector, which points along the
    fingers, where the whole of it may point to a bare wrist. Both over the square root of the
    blob's area, 0 for a blob without direction.
    """

    pixels: tuple[Floats, ...]
    pixel_area_px: float
    palms: Floats
    fingers: Floats
    silhouette: Silhouette | None = None

    def of(self, kept: Ints) -> BlobLooks:
        """Looks of the blobs of these numbers (k,)."""
        pixels = tuple(self.pixels[i] for i in kept)
        return replace(self, pixels=pixels, palms=self.palms[kept], fingers=self.fingers[kept])


def looks_of_ellipses(ellipses: Floats) -> BlobLooks:
    """Looks of blobs of which only the ellipses (n, 5) are known: a lattice filling each."""
    grid = np.linspace(-1.0, 1.0, 15)
    x, y = (axis.ravel() for axis in np.meshgrid(grid, grid))
    unit = np.column_stack([x, y])[x * x + y * y <= 1.0]
    pixels, areas = [], []
    for cx, cy, a, b, angle in ellipses:
        c, s = np.cos(angle), np.sin(angle)
        pixels.append(unit * (a, b) @ np.array([[c, s], [-s, c]]) + (cx, cy))
        areas.append(np.pi * a * b / len(unit))
    none = np.zeros((len(pixels), 2))
    return BlobLooks(tuple(pixels), float(np.median(areas)) if areas else 1.0, none, none)
