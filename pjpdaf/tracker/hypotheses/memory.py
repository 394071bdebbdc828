"""Memory that fades: how much of what was known still counts."""

from __future__ import annotations

import numpy as np


def kept_share(dt_s: float, memory_s: float) -> float:
    """Share of a running mean that is left after dt_s, to 1/e in memory_s; 0 without any memory."""
    return float(np.exp(-dt_s / memory_s)) if memory_s > 0 else 0.0
