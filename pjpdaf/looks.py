"""Looks of a view's blobs beyond their ellipses: silhouette, pixels, direction of fingers."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from pjpdaf.arrays import Floats, Ints

BACKGROUND, CLOTHED, SKIN = 0, 1, 2  # classes of a silhouette's pixels
PIXELS, MOST = 160, 120  # of a lattice that fills an ellipse


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
    """Looks of blobs of which only the ellipses (n, 5) are known: filled with one lattice's pixels.

    The lattice has PIXELS in the ellipse of median area.
    """
    areas = np.pi * ellipses[:, 2] * ellipses[:, 3]
    each = max(float(np.median(areas)) / PIXELS, 1e-6) if len(areas) else 1.0
    pixels = []
    for cx, cy, a, b, angle in ellipses:
        # So coarse that a huge ellipse has no more than MOST of them to a side.
        step = max(each**0.5, 2 * a / MOST, 1e-6)
        x, y = (np.arange(-(r // step), r // step + 1) * step for r in (a, b))
        grid = np.column_stack([axis.ravel() for axis in np.meshgrid(x, y)])
        inside = (grid[:, 0] / max(a, 1e-6)) ** 2 + (grid[:, 1] / max(b, 1e-6)) ** 2 <= 1.0
        c, s = np.cos(angle), np.sin(angle)
        pixels.append(grid[inside] @ np.array([[c, s], [-s, c]]) + (cx, cy))
    none = np.zeros((len(pixels), 2))
    return BlobLooks(tuple(pixels), each, none, none)
