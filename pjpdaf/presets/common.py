"""Departures that no preset can do without."""

from __future__ import annotations

from pjpdaf.presets.record import Departure

DIMENSION = Departure(
    "exponent of 2 pi",
    "(2 pi)^{m/2}, m the number of measurements (Eq. 3.32)",
    "the dimension of one measurement",
    "as printed, the weight of a measurement would depend on how many others there are",
    "none where a view has as many measurements as one measurement has rows",
)
INFINITY = Departure(
    "infinite measurement noise",
    "R = infinity in a view with an occlusion (Eq. 3.23)",
    "the view's rows are left out of z, H and S",
    "the limit of Eq. 3.12 for R to infinity, without dividing by it",
    "none",
)
WAIT = Departure(
    "start",
    "the first frame (section 3.6)",
    "the first frame whose views agree: residual, depth, distance between head and hands",
    "in 0-15 % of sequences a hand is hidden, or too small in one view, when the action starts",
    "a later start instead of a wrong one",
)
COMMON = (DIMENSION, INFINITY, WAIT)
