"""Pieces of bare arms: of two blobs on one forearm, the one before the other is the hand."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Floats
from pjpdaf.tracker.hypotheses.costs import FORWARD_MOST, HANDLIKE_COST
from pjpdaf.tracker.hypotheses.pairs import Pairs

FOREARM_M = 0.3  # from a hand to the far end of its forearm


def forearm_cost(pairs: Pairs, hands: NDArray[np.bool_], axes: Floats, forward_m: float) -> Floats:
    """Cost (n,) of taking a blob for a hand that a watch or a rolled sleeve cuts off its forearm.

    It grows by 1 for each forward_m [m] that another blob within a forearm's length is nearer to
    the cameras. hands (n,): pairs that may be hands; axes (3, 3): as of `Views`.
    """
    off = pairs.points_m[:, None] - pairs.points_m[None]
    apart = (pairs.blob[:, None] != pairs.blob[None]).all(axis=2)
    likely = hands & (pairs.cost < HANDLIKE_COST[1])
    on_one_arm = apart & likely[None] & (np.linalg.norm(off, axis=2) < FOREARM_M)
    nearer = np.clip(off @ axes[2] / forward_m, 0.0, FORWARD_MOST)
    return np.asarray(np.where(on_one_arm, nearer, 0.0).max(axis=1, initial=0.0))
