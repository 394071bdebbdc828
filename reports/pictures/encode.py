"""Pictures (h, w, 3) uint8 BGR as files in memory: JPEG, WebP, PNG."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from pjpdaf.arrays import Image


def jpeg_of(picture: Image, quality: int, *, optimised: bool = False) -> bytes:
    """Encode as JPEG of this quality (0-100); optimised: slower, a few per cent smaller."""
    settings = [cv2.IMWRITE_JPEG_QUALITY, quality]
    return _encoded(
        ".jpg", picture, [*settings, cv2.IMWRITE_JPEG_OPTIMIZE, 1] if optimised else settings
    )


def webp_of(picture: Image, quality: int) -> bytes:
    """Encode as WebP of this quality (1-100), lossless above 100."""
    return _encoded(".webp", picture, [cv2.IMWRITE_WEBP_QUALITY, quality])


def png_of(picture: Image) -> bytes:
    """Encode as PNG."""
    return _encoded(".png", picture, [])


def picture_of(data: bytes) -> Image | None:
    """Decode a file of any of these kinds, None where it is no picture."""
    if not data:
        return None
    picture = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)
    return None if picture is None else np.asarray(picture, np.uint8)


def _encoded(suffix: str, picture: Image, settings: Sequence[int]) -> bytes:
    done, data = cv2.imencode(suffix, picture, settings)
    assert done, "OpenCV always encodes a uint8 BGR picture"
    return bytes(data)
