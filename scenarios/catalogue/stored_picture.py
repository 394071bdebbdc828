"""A scenario's picture as bytes, and back, so that it need not be drawn twice."""

from __future__ import annotations

import itertools
import struct

import cv2
import numpy as np

from pjpdaf.arrays import Image
from scenarios.catalogue.scenario_picture import ScenarioPicture
from sim.dataset.files.encode import png

_LENGTHS = struct.Struct("<4sIII")  # magic, lengths of caption, large and small picture
_MAGIC = b"pict"


def picture_to_bytes(picture: ScenarioPicture) -> bytes:
    """Caption and pictures (PNG) as bytes."""
    parts = [picture.caption.encode(), png(picture.large), png(picture.small)]
    return _LENGTHS.pack(_MAGIC, *map(len, parts)) + b"".join(parts)


def picture_from_bytes(data: bytes) -> ScenarioPicture:
    """Inverse of `picture_to_bytes`. Raises ValueError for anything else."""
    try:
        magic, *lengths = _LENGTHS.unpack(data[: _LENGTHS.size])
    except struct.error as fault:
        raise ValueError("is no picture of a scenario") from fault
    if magic != _MAGIC or sum(lengths) != len(data) - _LENGTHS.size:
        raise ValueError("is no picture of a scenario")
    ends = np.cumsum([_LENGTHS.size, *lengths]).tolist()
    caption, large, small = (data[a:b] for a, b in itertools.pairwise(ends))
    return ScenarioPicture(_image(large), _image(small), caption.decode())


def _image(data: bytes) -> Image:
    image = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR) if data else None
    if image is None:
        raise ValueError("is no PNG picture")
    return np.asarray(image, np.uint8)
