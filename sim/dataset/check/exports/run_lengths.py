"""COCO's compressed run-length masks, decoded."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Floats


def run_lengths(
    segmentation: Mapping[str, Any], size_px: tuple[int, int]
) -> tuple[int, Floats, Floats]:
    """Pixels, centroid (2,) and box (4,) of COCO's compressed mask of a picture (width, height).

    Raises ValueError where it is none.
    """
    width, height = size_px
    runs = _runs(segmentation["counts"])
    if list(segmentation["size"]) != [height, width] or runs.sum() != width * height:
        raise ValueError("a mask is not of the picture's size")
    ends = np.cumsum(runs)
    first, last = ends[:-1:2], ends[1::2]  # of the runs that are set, in columns one below another
    first = first[: len(last)]
    some = last > first
    first, last = first[some], last[some]
    if len(first) == 0:
        return 0, np.full(2, np.nan), np.full(4, np.nan)
    # A run that passes the lower end of a column is cut there.
    flat = np.repeat(first - np.append(0, np.cumsum(last - first)[:-1]), last - first)
    flat = flat + np.arange(len(flat))
    xs, ys = flat // height, flat % height
    low, high = (xs.min(), ys.min()), (xs.max(), ys.max())
    box = (*low, high[0] - low[0] + 1, high[1] - low[1] + 1)
    return len(flat), np.array([xs.mean(), ys.mean()]), np.array(box, np.float64)


def _runs(counts: str) -> NDArray[np.int64]:
    """COCO's text: 5 bits a character from 48 on, the sixth says that more follow; from the third
    run on the difference to the last but one.
    """
    runs: list[int] = []
    value = shift = 0
    for code in counts.encode("ascii"):
        bits = code - 48
        if not 0 <= bits < 64 or shift > 60:
            raise ValueError("a mask's counts are damaged")
        value |= (bits & 31) << shift
        shift += 5
        if not bits & 32:
            if bits & 16:
                value -= 1 << shift
            runs.append(value + (runs[-2] if len(runs) > 2 else 0))
            value = shift = 0
    lengths = np.array(runs, np.int64)
    if len(lengths) == 0 or lengths.min() < 0:
        raise ValueError("a mask's counts are damaged")
    return lengths
