"""Picture files: which there are, how they are read, and pictures in which no skin can be found."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np

PICTURE_SUFFIXES = (".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff")
_GREY_LEVELS = 2  # by which channels of a grey video differ once it was compressed


def is_picture(file: Path) -> bool:
    """Whether a file is a picture by its name; hidden files are none."""
    hidden = file.name.startswith(".")
    return not hidden and file.suffix.lower() in PICTURE_SUFFIXES and file.is_file()


def read_picture(file: Path) -> np.ndarray | None:
    """Picture uint8 BGR (h, w, 3), turned upright as its EXIF says, None if unreadable.

    Videos are turned likewise, and so do OpenCV's own readers, with which people calibrate.
    """
    return _decoded(file, cv2.IMREAD_COLOR)


def stored_fault(file: Path) -> str:
    """Why the stored values of a picture cannot be used as they are; "" where they can.

    Ten or twelve bits in a file of sixteen are nearly black, once read as eight.
    """
    stored = _decoded(file, cv2.IMREAD_UNCHANGED)
    if stored is None or stored.dtype != np.uint16 or not 0 < int(stored.max()) < 1 << 13:
        return ""
    bits = max(8, int(stored.max()).bit_length())
    return (
        f"{file}: is a picture of 16 bits whose values use {bits}: nearly black. Convert the "
        f"pictures to 8 bits, all values divided by {1 << (bits - 8)}"
    )


def is_grey(pictures: Sequence[np.ndarray]) -> bool:
    """Whether no pixel of any of these BGR pictures has a colour."""
    differences = (np.ptp(picture.astype(np.int16), axis=2).max() for picture in pictures)
    return bool(pictures) and all(int(d) <= _GREY_LEVELS for d in differences)


def _decoded(file: Path, flags: int) -> np.ndarray | None:
    level = cv2.utils.logging.getLogLevel()
    # The caller names the file; OpenCV would print five lines about it.
    cv2.utils.logging.setLogLevel(0)
    try:
        data = np.fromfile(file, np.uint8)  # not imread: it cannot open every path on every system
        if len(data) == 0:
            return None
        picture: np.ndarray | None = cv2.imdecode(data, flags)
    except (OSError, cv2.error):
        return None
    finally:
        cv2.utils.logging.setLogLevel(level)
    return picture
