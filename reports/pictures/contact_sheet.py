"""Many small pictures on one sheet, and pictures small enough for a repository."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pjpdaf.arrays import Image
from reports.pictures.encode import jpeg_of
from reports.pictures.overlay import STRIP

GAP_PX = 8
PICTURE_BYTES = 12_000  # of a picture in a repository
_QUALITIES = range(85, 19, -5)


def contact_sheet(pictures: Sequence[Image], columns: int) -> Image:
    """Lay pictures (h, w, 3) of one size out row by row (H, W, 3) on the strip's colour."""
    height, width = pictures[0].shape[:2]
    rows = -(-len(pictures) // columns)
    across, down = columns * (width + GAP_PX) + GAP_PX, rows * (height + GAP_PX) + GAP_PX
    sheet = np.full((down, across, 3), STRIP, dtype=np.uint8)
    for i, picture in enumerate(pictures):
        row, column = divmod(i, columns)
        y, x = GAP_PX + row * (height + GAP_PX), GAP_PX + column * (width + GAP_PX)
        sheet[y : y + height, x : x + width] = picture
    return sheet


def small_jpeg(picture: Image, most_bytes: int = PICTURE_BYTES) -> bytes:
    """Encode a picture (h, w, 3) BGR as the best JPEG within a size, else as the smallest."""
    jpeg = b""
    for quality in _QUALITIES:
        jpeg = jpeg_of(picture, quality, optimised=True)
        if len(jpeg) <= most_bytes:
            break
    return jpeg
