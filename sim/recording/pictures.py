"""Pictures of a still camera without loss: zstd of the difference to the view's picture before.

Where nothing moves the difference is zero: 0.1 MB and 2 ms a stereo frame, against 0.55 MB and 25
ms as PNG.
"""

from __future__ import annotations

import numpy as np
import pyarrow as pa

from pjpdaf.arrays import Image

LEVEL = 3


class PictureEncoder:
    """Encodes the pictures of a view, in order."""

    def __init__(self) -> None:
        self._codec = pa.Codec("zstd", LEVEL)
        self._before: Image | None = None

    def encode(self, picture: Image) -> bytes:
        """A picture (h, w, 3), of the same size as those before."""
        change = picture if self._before is None else picture - self._before
        self._before = picture.copy()
        data: bytes = self._codec.compress(np.ascontiguousarray(change), asbytes=True)
        return data


class PictureDecoder:
    """Decodes the pictures of a view of this size, in order."""

    def __init__(self, height_px: int, width_px: int) -> None:
        self._codec = pa.Codec("zstd")
        self._before: Image = np.zeros((height_px, width_px, 3), np.uint8)

    def decode(self, data: bytes) -> Image:
        """The next picture; not to be written into. Raises ValueError for data that are none."""
        size = self._before.nbytes
        try:
            change = self._codec.decompress(data, size, asbytes=True)
        except OSError as fault:  # of Arrow
            raise ValueError("is not a compressed picture") from fault
        if len(change) != size:
            raise ValueError(f"a picture of {len(change)} bytes, must have {size}")
        picture = np.frombuffer(change, np.uint8).reshape(self._before.shape) + self._before
        self._before = picture
        return picture
