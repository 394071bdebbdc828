"""Boxes of masks, and the instances that hide a target."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Floats
from pjpdaf.targets import TARGETS


def box_of(mask: NDArray[np.bool_]) -> Floats:
    """x, y, width, height (4,) of a mask, NaN where it is empty."""
    columns, rows = np.flatnonzero(mask.any(axis=0)), np.flatnonzero(mask.any(axis=1))
    if len(rows) == 0:
        return np.full(4, np.nan)
    x, y = columns[0], rows[0]
    return np.array([x, y, columns[-1] - x + 1, rows[-1] - y + 1], np.float64)


def hidden(
    amodal: NDArray[np.bool_], instances: NDArray[np.uint8], highest: int
) -> NDArray[np.int64]:
    """Pixels (T, highest + 1) of each target's amodal mask that show another instance."""
    counts = np.array([np.bincount(instances[mask], minlength=highest + 1) for mask in amodal])
    counts[np.arange(len(TARGETS)), 1 + np.arange(len(TARGETS))] = 0
    return counts.astype(np.int64)
