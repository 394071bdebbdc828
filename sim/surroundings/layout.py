"""Places in a row: things beside each other along a wall, none over another."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np


def in_a_row(
    rng: np.random.Generator, span_m: tuple[float, float], widths_m: Sequence[float]
) -> list[float | None]:
    """Middles [m] of things of these widths within a span, in a drawn order with drawn gaps.

    None for those for which there is no room: the first of the sequence come first.
    """
    low, high = span_m
    left = high - low
    kept = []
    for number, width in enumerate(widths_m):
        if width <= left:
            kept.append(number)
            left -= width
    rng.shuffle(kept)
    gaps = rng.dirichlet(np.full(len(kept) + 1, 2.0)) * left
    places: list[float | None] = [None] * len(widths_m)
    at = low
    for gap, number in zip(gaps.tolist(), kept, strict=False):
        at += gap
        places[number] = at + widths_m[number] / 2
        at += widths_m[number]
    return places
