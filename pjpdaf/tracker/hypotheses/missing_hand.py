"""A hand that is missing beside the head: the head's blob then shows it too, however large it is.

A hand that holds a cup before the face hides as much skin as it shows, and a head that turns shows
less: the area of the head's blob does not tell that a hand is in it. That the hand was near, and
that no blob is left which could be it, does.
"""

from __future__ import annotations

import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.tracker.hypotheses.blobs import Blobs

NEAR_M = 0.25  # from the head's centre to a hand that may be at the head
LEAST_SHARE = 0.3  # of a whole hand's area, of a blob that may be one


def hand_missing(view: Blobs, head_m: Floats, hands_m: Floats, hand_px: float) -> bool:
    """Whether a hand that was near the head is seen nowhere else in a view.

    head_m (3,), hands_m (2, 3): where they were [m]; hand_px: area of a whole hand there [px].
    """
    near = int((np.linalg.norm(hands_m - head_m, axis=1) < NEAR_M).sum())
    others = int((view.areas_px > LEAST_SHARE * hand_px).sum()) - 1  # one is the head
    return near > 0 and not view.missing and others < len(hands_m)
