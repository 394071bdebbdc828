"""The grid of a chart: lines, numbers and titles of both axes."""

from __future__ import annotations

from collections.abc import Iterable

from markupsafe import escape

from reports.page.charts.svg import BOTTOM, LEFT, RIGHT, WIDTH

Tick = tuple[float, str]  # pixel and text


def grid(
    x_ticks: Iterable[Tick], y_ticks: Iterable[Tick], titles: tuple[str, str], top: int, bottom: int
) -> str:
    """Draw the grid between the pixels `top` and `bottom`. titles: of x and y.

    Without a title the x axis has lines alone: its numbers are at a chart below.
    """
    parts = []
    for y, text in y_ticks:
        parts.append(
            f'<line class="grid" x1="{LEFT}" x2="{WIDTH - RIGHT}" y1="{y:.1f}" y2="{y:.1f}"/>'
            f'<text x="{LEFT - 7}" y="{y + 4:.1f}" text-anchor="end">{escape(text)}</text>'
        )
    for x, text in x_ticks:
        parts.append(
            f'<line class="grid" x1="{x:.1f}" x2="{x:.1f}" y1="{top}" y2="{bottom}"/>'
            + (_x_number(x, bottom, text) if titles[0] else "")
        )
    if titles[0]:
        parts.append(
            f'<text x="{(LEFT + WIDTH - RIGHT) / 2}" y="{bottom + BOTTOM - 8}" '
            f'text-anchor="middle">{escape(titles[0])}</text>'
        )
    parts.append(
        f'<text transform="translate(14 {(top + bottom) / 2}) rotate(-90)" text-anchor="middle">'
        f"{escape(titles[1])}</text>"
    )
    return "".join(parts)


def _x_number(x: float, bottom: int, text: str) -> str:
    return f'<text x="{x:.1f}" y="{bottom + 17}" text-anchor="middle">{escape(text)}</text>'
