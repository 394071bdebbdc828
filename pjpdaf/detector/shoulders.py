"""Where the head ends: the row from which the silhouette widens to the shoulders."""

from __future__ import annotations

import numpy as np

from pjpdaf.arrays import Bools

LEAST_HEAD_M = 0.13  # from the top, however wide the silhouette is
SHOULDERS = 1.35  # width over the widest row above
BESIDE_M = 0.2  # from the head's middle: what is farther to a side says nothing


def rows_of_head(person: Bools, top: int, height: int, middle: float, metre_px: float) -> int:
    """Rows from the top, at most `height`, that are above the shoulders of a silhouette (h, w).

    middle: the head's column; metre_px: pixels of a metre. The farther a person is, or the lower
    the chin, the more shirt shows within a head's usual height, and it may have a colour near skin.
    """
    left, right = max(int(middle - BESIDE_M * metre_px), 0), int(middle + BESIDE_M * metre_px)
    widths = person[top : top + height, left : right + 1].sum(axis=1)
    widest = np.maximum.accumulate(widths)
    wide = 1 + np.flatnonzero(widths[1:] > SHOULDERS * widest[:-1])
    wide = wide[wide >= max(int(LEAST_HEAD_M * metre_px), 4)]
    return int(wide[0]) if len(wide) else height
