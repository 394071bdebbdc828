"""A chart of lines with axes, ticks and a legend."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from markupsafe import Markup, escape

from pjpdaf.arrays import Floats
from reports.page.charts.grid import grid
from reports.page.charts.svg import (
    BOTTOM,
    LEFT,
    RIGHT,
    TOP,
    WIDTH,
    Axis,
    legend,
    marker,
    path_data,
    svg,
)


@dataclass(frozen=True, eq=False)
class Series:
    """A line of a chart: x, y (n,), NaN for a gap; texts (n,) of the points, or none."""

    target: str
    x: Floats
    y: Floats
    texts: tuple[str, ...] = ()


def line_chart(
    series: Sequence[Series],
    titles: tuple[str, str],
    *,
    log_x: bool = False,
    y_range: tuple[float, float] | None = None,
    x_ticks: Sequence[float] | None = None,
    marks: bool = True,
    limit: tuple[float, str] | None = None,
    height: int = 300,
) -> Markup:
    """Draw lines over x.

    titles: of x and y; y_range: of the axis, else from 0 to the largest value; marks: a marker per
    point; limit: a level and its name.
    """
    xs = np.concatenate([s.x for s in series]) if series else np.zeros(0)
    ys = np.concatenate([s.y for s in series]) if series else np.zeros(0)
    ys = ys[np.isfinite(ys)]
    top = max([float(ys.max())] if len(ys) else [1.0], default=1.0)
    if limit is not None:
        top = max(top, limit[0])
    low, high = y_range or (0.0, top * 1.05 or 1.0)
    x0, x1 = (float(xs.min()), float(xs.max())) if len(xs) else (0.0, 1.0)
    if x0 == x1:
        x0, x1 = x0 / 1.2, x1 * 1.2 or 1.0
    x_axis = Axis(x0, x1, LEFT + 6, WIDTH - RIGHT - 6, log_x)
    y_axis = Axis(low, high, height - BOTTOM, TOP)
    ticks = x_axis.ticks() if x_ticks is None else x_ticks
    parts = [grid(x_axis.numbered(ticks), y_axis.numbered(), titles, TOP, height - BOTTOM)]
    if limit is not None:
        y = y_axis.at(limit[0])
        parts.append(
            f'<line class="limit" x1="{LEFT}" x2="{WIDTH - RIGHT}" y1="{y:.1f}" y2="{y:.1f}"/>'
            f'<text class="soft" x="{WIDTH - RIGHT}" y="{y - 5:.1f}" text-anchor="end">'
            f"{escape(limit[1])}</text>"
        )
    for line in series:
        places = np.column_stack([x_axis.all(line.x), y_axis.all(np.clip(line.y, low, high))])
        parts.append(f'<path class="line {line.target}" d="{path_data(places)}"/>')
        if marks:
            parts += [
                marker(line.target, x, y, 4.5, line.texts[i] if line.texts else "")
                for i, (x, y) in enumerate(places.tolist())
                if math.isfinite(y)
            ]
    parts.append(legend([s.target for s in series]))
    return svg(parts, height, f"{titles[1]} against {titles[0]}")
