"""Two systems on the same draws: how often either fails, and the difference with its interval."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from reports.gate.statistics import wilson


@dataclass(frozen=True)
class PairedFailures:
    """Draws by who failed. difference: P(b) - P(a), low, high: its 95 % interval."""

    both: int
    only_a: int
    only_b: int
    neither: int
    difference: float
    low: float
    high: float
    p_value: float


def paired_failures(a: Sequence[bool], b: Sequence[bool]) -> PairedFailures:
    """Compare outcomes on common draws, in the same order.

    Interval: Newcombe's of paired shares (1998, method 10), of two Wilson intervals and their
    correlation; p-value: exact McNemar, two-sided, of the draws in which the two differ.
    """
    from scipy.stats import binomtest  # takes half a second to load: every command would wait

    pairs = list(zip(a, b, strict=True))
    both, only_a, only_b = (pairs.count(k) for k in ((True, True), (True, False), (False, True)))
    n = len(pairs)
    neither = n - both - only_a - only_b
    low, high = _newcombe(both, only_a, only_b, neither)
    differing = only_a + only_b
    p_value = float(binomtest(only_b, differing, 0.5).pvalue) if differing else 1.0
    difference = (only_b - only_a) / n if n else 0.0
    return PairedFailures(both, only_a, only_b, neither, difference, low, high, p_value)


def _newcombe(both: int, only_a: int, only_b: int, neither: int) -> tuple[float, float]:
    n = both + only_a + only_b + neither
    if n == 0:
        return -1.0, 1.0
    pa, pb = (both + only_a) / n, (both + only_b) / n
    (la, ua), (lb, ub) = wilson(both + only_a, n), wilson(both + only_b, n)
    margins = (both + only_a) * (only_b + neither) * (both + only_b) * (only_a + neither)
    product = float(both * neither - only_a * only_b)
    if product > 0:  # a correction for continuity, only towards 0
        product = max(product - n / 2, 0.0)
    phi = product / math.sqrt(margins) if margins else 0.0

    def reach(up: float, down: float) -> float:
        return math.sqrt(max(up**2 - 2 * phi * up * down + down**2, 0.0))

    difference = pb - pa
    return difference - reach(pb - lb, ua - pa), difference + reach(ub - pb, pa - la)
