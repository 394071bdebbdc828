"""Stereo frames: the pictures of all cameras at one moment."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class StereoFrame:
    """Pictures of all views at one moment.

    index counts from 0; time_s [s]; pictures: per view uint8 BGR (h, w, 3), or None where the
    picture is missing (a dropped or corrupt frame counts as a missed detection, never as an error).
    """

    index: int
    time_s: float
    pictures: Sequence[np.ndarray | None]
