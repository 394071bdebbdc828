"""Made-up truths of frames, for tests of what is chosen and written by them."""

import numpy as np

from sim.truth import Truth, ViewTruth


def truth(index, events=(), merged=0, visible=1000):
    """A made-up truth: the first `merged` pairs are merged, in both views."""
    pairs = np.zeros((3, 3), bool)
    for a, b in ((1, 2), (0, 1), (0, 2))[:merged]:
        pairs[a, b] = pairs[b, a] = True
    view = ViewTruth(
        np.zeros((3, 2)), np.array([1000, visible, 1000]), [1000] * 3, np.zeros((3, 4)), pairs
    )
    zero = np.zeros((3, 3))
    return Truth(index, index / 3, zero, zero, zero, (view, view), tuple(events))
