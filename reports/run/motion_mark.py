"""A mark of an episode's true motion, by which a changed simulator is noticed."""

from __future__ import annotations

import numpy as np

from pjpdaf.arrays import Floats

SAME_MOTION_UM = 2  # both marks are rounded, and processors differ in the last bits
_GOLDEN = (5**0.5 - 1) / 2


def motion_mark(centres_m: Floats) -> str:
    """Condense all true centres (F, T, 3) [m] into a number per target [um], as text.

    A mean with weights that differ from number to number, so that any other motion, order or
    length changes it. No digest: processors differ in the last bits, which stay last bits here.
    """
    flat_m = np.moveaxis(centres_m, 1, 0).reshape(centres_m.shape[1], -1)
    n = flat_m.shape[1]
    weights = 2.0 * np.modf(_GOLDEN * np.arange(1, n + 1))[0] - 1.0
    marks_m = (flat_m * weights).sum(axis=1) / np.sqrt(n)
    return " ".join(str(round(1e6 * float(mark))) for mark in marks_m)


def same_motion(mark: str, other: str) -> bool:
    """Whether two marks belong to the same motion."""
    try:
        a, b = ([int(number) for number in text.split()] for text in (mark, other))
    except ValueError:  # of an older version
        return mark == other
    return len(a) == len(b) and all(abs(x - y) <= SAME_MOTION_UM for x, y in zip(a, b, strict=True))
