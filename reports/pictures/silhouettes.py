"""Painted silhouettes as a small plain picture, where nothing was rendered."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from reports.pictures.encode import webp_of
from reports.pictures.stills import VIEW_WIDTH_PX
from sim.silhouettes.shapes import BARE, CLOTHED, EMPTY, PAINTS, STANDING, TARGET_PAINT

QUALITY = 40  # of WebP; about 4 kB a frame of two views
_SKIN = (139, 170, 210)  # BGR
_COLOURS = {
    EMPTY: (51, 42, 35),
    STANDING: (74, 63, 54),
    CLOTHED: (112, 97, 84),
    BARE: (104, 128, 158),
    **dict.fromkeys(range(TARGET_PAINT, PAINTS), _SKIN),
}
_PALETTE = np.array([_COLOURS[paint] for paint in range(PAINTS)], dtype=np.uint8)


def silhouette_still(views: Sequence[NDArray[np.uint8]]) -> bytes:
    """Encode all views of a frame side by side, each `VIEW_WIDTH_PX` wide, as WebP.

    views: the paint (h, w) of each pixel (`sim.silhouettes.shapes`). Skin is light, all of one
    tone, as a detector sees it.
    """
    pictures = []
    for paints in views:
        height = round(VIEW_WIDTH_PX * paints.shape[0] / paints.shape[1])
        size = (VIEW_WIDTH_PX, height)
        pictures.append(cv2.resize(_PALETTE[paints], size, interpolation=cv2.INTER_AREA))
    height = max(len(picture) for picture in pictures)
    padded = [np.pad(p, ((0, height - len(p)), (0, 0), (0, 0))) for p in pictures]
    return webp_of(np.hstack(padded), QUALITY)
