"""Motion of both hands: hands near each other may have changed places between two frames."""

from __future__ import annotations

import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.tracker.hypotheses.motion import steps
from pjpdaf.tracker.hypotheses.parameters import MotionParameters

AT_HEAD_M = 0.25  # from the face: hands there wait, and no sleeve tells them apart


def both_hands(
    each: Floats, hands_m: Floats, face_m: Floats, seen: int, dt_s: float, m: MotionParameters
) -> Floats:
    """Cost (K, c, c) of every pair of choices of right and left; each (K, 2, c) of either alone.

    hands_m (K, 2, 3): where they were; face_m (3,); seen: so many choices, the first, are
    sightings.

    Displacements that are drawn independently say of two hands which are found where two hands were
    that both stayed: it takes chance for each to end in the other's place. Hands that roll round
    each other do so all the time. So the names of the two places are worth `exchange_cost` at
    most, and what the distance of the hands costs as a fast movement.
    """
    straight = np.asarray(each[:, 0, :, None] + each[:, 1, None, :])
    if m.exchange_cost == 0:
        return straight
    apart_m2 = ((hands_m[:, 0] - hands_m[:, 1]) ** 2).sum(axis=1)
    cost = m.exchange_cost + 0.5 * apart_m2 / steps(dt_s, m.deviations_m).max()
    at_head = np.linalg.norm(hands_m - face_m, axis=2).min(axis=1) < AT_HEAD_M
    cost = np.where(at_head, np.inf, cost)
    here = straight[:, :seen, :seen]
    bounded = straight.copy()
    bounded[:, :seen, :seen] = np.minimum(here, here.swapaxes(1, 2) + cost[:, None, None])
    return bounded
