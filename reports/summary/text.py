"""Names, numbers, shares and counts as the tables and pages write them."""

from __future__ import annotations

import math


def number(value: float) -> str:
    """Three figures; "∞" where most frames lack an estimate, "-" without any frame."""
    if math.isnan(value):
        return "-"
    if math.isinf(value):
        return "∞"
    return f"{value:.1f}" if abs(value) < 99.95 else f"{value:.0f}"


def percent(share: float) -> str:
    """A share 0-1 as per cent. Never rounded up to 100 or down to 0."""
    if math.isnan(share):
        return "-"
    text = f"{100 * share:.1f}"
    if text == "100.0" and share < 1:
        text = "> 99.9"
    elif text == "0.0" and share > 0:
        text = "< 0.1"
    return {"100.0": "100", "0.0": "0"}.get(text, text) + " %"


def count(n: int, noun: str) -> str:
    """'1 episode', '2 episodes'."""
    return f"{n} {noun}" if n == 1 else f"{n} {noun}s"


def duration(seconds: float) -> str:
    """A time span for reading: '45 s', '5 min 10 s', '2 h 5 min'."""
    whole = round(seconds)
    if whole < 60:
        return f"{whole} s"
    minutes, rest = divmod(whole, 60)
    if minutes < 60:
        return f"{minutes} min {rest} s" if rest else f"{minutes} min"
    hours, minutes = divmod(minutes, 60)
    return f"{hours} h {minutes} min" if minutes else f"{hours} h"
