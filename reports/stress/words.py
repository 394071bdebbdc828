"""Goals in short, shares and intervals in words."""

from __future__ import annotations

from reports.score.robustness import Goal

GOAL_SHORT: dict[Goal, str] = {"swap": "P(swap)", "head": "P(head swap)", "lost": "P(lost)"}


def share_text(share: float) -> str:
    """A share 0-1 as per cent: two digits below 10 %, whole above; 0 and 1 only where exact."""
    if share in (0.0, 1.0):
        return f"{100 * share:g} %"
    percent = 100 * share
    text = f"{percent:.2g}" if percent < 9.95 else f"{percent:.0f}"
    return "> 99 %" if text == "100" else f"{text} %"


def interval_text(p: float, low: float, high: float) -> str:
    """Such as "4.1 % (3.2 to 5.2)", "below 0.15 %" where nothing failed."""
    if p == 0.0:
        return f"below {share_text(high)}"
    return f"{share_text(p)} ({share_text(low)[:-2]} to {share_text(high)[:-2]})"


def value_text(value: float | str, unit: str) -> str:
    """A value with its unit; "1" is none."""
    text = value if isinstance(value, str) else f"{value:.4g}"
    return text if unit in ("1", "") else f"{text} {unit}"
