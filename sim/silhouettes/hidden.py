"""Parts that the table hides."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Floats
from sim.silhouettes.shapes import Bars
from sim.specs import RoomSpec


def below_table(bars: Bars, room: RoomSpec, centre_w: Floats) -> NDArray[np.bool_]:
    """Whether the middle of each bar (F, n) is seen through the table's top from centre_w (3,)."""
    middle = 0.5 * (bars.starts_m + bars.ends_m)
    top = room.table_height_m
    below = middle[..., 2] < top
    if not below.any():
        return np.zeros(below.shape, dtype=bool)
    share = (top - middle[..., 2]) / np.maximum(centre_w[2] - middle[..., 2], 1e-6)
    crossed = middle[..., :2] + share[..., None] * (centre_w[:2] - middle[..., :2])
    near, far = room.table_near_x_m, room.table_near_x_m + room.table_depth_m
    on = (crossed[..., 0] >= near) & (crossed[..., 0] <= far)
    on &= np.abs(crossed[..., 1]) <= 0.5 * room.table_width_m
    return np.asarray(below & on)
