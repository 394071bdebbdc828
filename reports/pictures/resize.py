"""Pictures at another width."""

from __future__ import annotations

import cv2
import numpy as np

from pjpdaf.arrays import Image


def resized(picture: Image, width_px: int, exact: bool = False) -> Image:
    """Scale a picture (h, w, 3) to this width; exact: by nearest neighbour, mixing no colours."""
    height = max(round(width_px * picture.shape[0] / picture.shape[1]), 1)
    method = cv2.INTER_NEAREST if exact else cv2.INTER_AREA
    return np.asarray(cv2.resize(picture, (width_px, height), interpolation=method), np.uint8)
