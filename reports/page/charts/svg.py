"""Elements of the page's charts: axes, paths, markers, the legend.

Colours are the page's own (classes `head`, `right_hand`, `left_hand`, ...), so that they follow the
reader's theme and print; a target has its own dash and marker as well: colour is never the only
sign.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from markupsafe import Markup, escape

from pjpdaf.arrays import Floats
from pjpdaf.targets import TARGETS
from reports.words import LABELS

WIDTH = 480  # of a chart, in its own units; text is 13 of these high
LEFT, RIGHT, TOP, BOTTOM = 52, 12, 30, 44


def path_data(places: Floats) -> str:
    """SVG path data through points (n, 2), lifted at NaN."""
    steps, down = [], False
    for x, y in places.tolist():
        if math.isfinite(x) and math.isfinite(y):
            steps.append(f"{'L' if down else 'M'}{x:.1f} {y:.1f}")
            down = True
        else:
            down = False
    return "".join(steps)


def marker(
    target: str, x: float, y: float, size: float, text: str = "", *, hollow: bool = False
) -> str:
    """A target's marker: circle, square or diamond; text: shown beside the pointer."""
    title = f"<title>{escape(text)}</title>" if text else ""
    kind = f"mark {target}{' hollow' if hollow else ''}"
    if target == TARGETS[0]:
        return f'<circle class="{kind}" cx="{x:.1f}" cy="{y:.1f}" r="{size}">{title}</circle>'
    turn = f' transform="rotate(45 {x:.1f} {y:.1f})"' if target == TARGETS[2] else ""
    return (
        f'<rect class="{kind}" x="{x - size:.1f}" y="{y - size:.1f}" '
        f'width="{2 * size}" height="{2 * size}"{turn}>{title}</rect>'
    )


def svg(elements: Sequence[str], height: int, label: str) -> Markup:
    """Put a chart of `WIDTH` x height together; label: the chart in words."""
    # Names from outside went through `escape` where they were put in.
    content = "".join(elements)
    role = "group" if "<a " in content else "img"  # what is in an image cannot be reached
    return Markup(
        f'<svg class="chart" viewBox="0 0 {WIDTH} {height}" role="{role}" '
        f'aria-label="{escape(label)}">{content}</svg>'
    )


@dataclass(frozen=True)
class Axis:
    """Maps values low..high to pixels start..end, linearly or by logarithm."""

    low: float
    high: float
    start: float
    end: float
    log: bool = False

    def all(self, values: Floats) -> Floats:
        """Pixels of values."""
        low, high = self.low, self.high
        if self.log:
            values, low, high = np.log(values), math.log(low), math.log(high)
        return np.asarray(self.start + (values - low) / (high - low) * (self.end - self.start))

    def at(self, value: float) -> float:
        """Pixel of a value."""
        return float(self.all(np.array(value)))

    def ticks(self) -> list[float]:
        """Round values, about five."""
        step = round_step((self.high - self.low) / 5)
        first = math.ceil(self.low / step - 1e-9)
        last = math.floor(self.high / step + 1e-9)
        return [round(i * step, 10) for i in range(first, last + 1)]

    def numbered(self, values: Sequence[float] | None = None) -> list[tuple[float, str]]:
        """Pixel and text of values, of the ticks without."""
        return [(self.at(v), f"{v:g}") for v in (self.ticks() if values is None else values)]


def round_step(least: float) -> float:
    """The smallest of 1, 2, 5 times a power of ten that is at least `least`."""
    power = 10.0 ** math.floor(math.log10(least))
    return next(f * power for f in (1.0, 2.0, 5.0, 10.0) if f * power >= least * (1 - 1e-9))


def legend(targets: Sequence[str]) -> str:
    """Line, marker and name of each target in a row."""
    parts, x = [], float(LEFT)
    for target in dict.fromkeys(targets):
        parts.append(
            f'<path class="line {target}" d="M{x:.0f} 14H{x + 26:.0f}"/>'
            + marker(target, x + 13, 14, 4)
            + f'<text x="{x + 32:.0f}" y="18">{LABELS[target]}</text>'
        )
        x += 48 + 7.8 * len(LABELS[target])
    return "".join(parts)
