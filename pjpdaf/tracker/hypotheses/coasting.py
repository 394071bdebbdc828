"""Where a hand that vanishes goes on to: it does not stop where it was last seen."""

from __future__ import annotations

import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.tracker.hypotheses.memory import kept_share

MEMORY_S = 0.12  # of the mean velocity of a hand that is seen
FASTEST_MPS = 2.0


def learnt_velocity(velocity: Floats, moved_m: Floats, dt_s: float) -> Floats:
    """Mean velocity (3,) [m/s] of a hand that was seen to move by moved_m (3,) [m] in dt_s.

    The displacements of the last MEMORY_S count, so that noise does not grow with the frame rate.
    """
    if dt_s <= 0:
        return velocity
    fresh = 1.0 - kept_share(dt_s, MEMORY_S)
    mean = velocity + fresh * (moved_m / dt_s - velocity)
    speed = float(np.linalg.norm(mean))
    return np.asarray(mean * min(1.0, FASTEST_MPS / max(speed, 1e-9)))


def coasted(velocity: Floats, dt_s: float, coast_s: float) -> tuple[Floats, Floats]:
    """Displacement (3,) [m] in dt_s of a hand that nobody sees, and its velocity after it.

    The velocity decays with the time constant coast_s: in all the hand goes velocity * coast_s.
    coast_s 0: it stays.
    """
    if coast_s <= 0:
        return np.zeros(3), velocity
    left = kept_share(dt_s, coast_s)
    return np.asarray(velocity * coast_s * (1.0 - left)), np.asarray(velocity * left)
