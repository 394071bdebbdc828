"""Activity: how far the hands lately moved from frame to frame, and what motion then says of names.

Hands that roll round each other have changed places by the next frame as often as not. A random
walk takes the shorter way for the true one, however clearly the sleeves name the hands. So the more
the hands moved in the frames before, the less motion counts where two places could also be named
the other way round.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Floats
from pjpdaf.tracker.hypotheses.memory import kept_share
from pjpdaf.tracker.hypotheses.parameters import MotionParameters

AT_HEAD_M = 0.2  # nearer to the face, sleeves hardly tell the hands apart


def speed_after(
    before_mps: float,
    before_m: Floats,
    after_m: Floats,
    seen: NDArray[np.bool_],
    dt_s: float,
    memory_s: float,
) -> float:
    """Root mean square speed [m/s] of the hands over the time memory_s.

    before_m, after_m (2, 3): places a frame apart, dt_s; seen (2,): bool, hands that are not seen
    have no speed.
    """
    if dt_s <= 0 or not seen.any():
        return before_mps
    now = (((after_m - before_m) / dt_s) ** 2).sum(axis=1)[seen].mean()
    kept = kept_share(dt_s, memory_s)
    return float(np.sqrt(kept * before_mps**2 + (1.0 - kept) * now))


def share_of_motion(
    speeds_mps: Sequence[float],
    costs: Sequence[float],
    told: float,
    dt_s: float,
    m: MotionParameters,
) -> float:
    """How much motion counts for the names: 1 for hands at rest, 1/2 where they move by
    `naming_step_m` in dt_s.

    told: how much of the evidence of sleeves that there can be this frame brings; where nothing but
    motion names the hands, it counts in full. speeds_mps, costs: of all hypotheses. They share one
    speed: if each had its own, the one that took hands for moving would be blamed for it once they
    rest.
    """
    if m.naming_step_m <= 0:
        return 1.0
    weights = np.exp(min(costs) - np.array(costs))
    speed2 = float(weights @ np.square(speeds_mps) / weights.sum())
    return 1.0 - told * (1.0 - 1.0 / (1.0 + speed2 * (dt_s / m.naming_step_m) ** 2))


def tempered(each: Floats, points_m: Floats, face_m: Floats, share: float) -> Floats:
    """Costs (K, n, n) of two places for right and left, from those of each hand, each (K, 2, n).

    points_m (n, 3): the places; face_m (3,). What one naming of two places costs beyond the other
    counts by share, but not at the head.
    """
    both = each[:, 0, :, None] + each[:, 1, None, :]
    if share < 1.0:
        away = np.linalg.norm(points_m - face_m, axis=1) > AT_HEAD_M
        beyond = np.maximum(both - both.swapaxes(1, 2), 0.0)
        both = both - (1.0 - share) * beyond * (away[:, None] & away[None, :])
    return np.asarray(both)
