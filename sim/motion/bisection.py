"""Bisection: where along an interval a condition begins to hold."""

from __future__ import annotations

from collections.abc import Callable


def bisect(
    low: float, high: float, rounds: int, holds: Callable[[float], bool]
) -> tuple[float, float]:
    """Halve an interval `rounds` times about where `holds` turns from False to True.

    Returns (low, high): the condition fails at low and holds at high, if it did so at the start.
    """
    for _ in range(rounds):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if holds(middle) else (middle, high)
    return low, high
