"""Lines over time in panels one below the other, and lanes of what each target went through."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from markupsafe import Markup, escape

from pjpdaf.arrays import Floats
from pjpdaf.targets import TARGETS
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
from reports.words import LABELS

PANEL, GAP, LANE = 118, 16, 19  # heights
LEAST_SPAN = 0.02  # of an axis, so that noise does not fill a panel


@dataclass(frozen=True, eq=False)
class Panel:
    """The lines of all targets, over the same times as in other panels.

    y (F, T), NaN for a gap; down: larger values are drawn lower.
    """

    title: str
    y: Floats
    down: bool = False


@dataclass(frozen=True)
class Span:
    """What a target went through from `start` to `end` [s]; kind: its class in the style."""

    target: str
    kind: str
    start: float
    end: float
    text: str


def panel_chart(
    times_s: Floats,
    panels: Sequence[Panel],
    spans: Sequence[Span],
    *,
    hollow: Floats,
    shades: Sequence[tuple[float, float]] = (),
    marks: bool = True,
) -> Markup:
    """Draw panels over time, and below them a lane of spans for each target.

    hollow (F, T) bool: samples whose marker is not filled; shades: times [s] that are shaded in
    all panels; marks: a marker for each sample.
    """
    ends = [*times_s.tolist(), *(span.end for span in spans)]
    x = Axis(min(ends), max(ends), LEFT + 4, WIDTH - RIGHT - 4)
    floor = TOP + len(panels) * (PANEL + GAP)
    bottom = floor + LANE * len(TARGETS)
    parts = [
        f'<rect class="shade" x="{x.at(start):.1f}" y="{TOP}" '
        f'width="{x.at(end) - x.at(start):.1f}" height="{bottom - TOP}"/>'
        for start, end in shades
    ]
    for n, panel in enumerate(panels):
        top = TOP + n * (PANEL + GAP)
        y = _axis(panel, top)
        parts.append(grid(x.numbered(), y.numbered(), ("", panel.title), top, top + PANEL))
        parts += _lines(times_s, panel, x, y, hollow if marks else None)
    parts.append(grid(x.numbered(), (), ("time [s]", ""), floor, bottom))
    parts += _lanes(spans, x, floor)
    parts.append(legend(TARGETS))
    label = f"{', '.join(panel.title for panel in panels)} over time; status of each target"
    return svg(parts, bottom + BOTTOM, label)


def _axis(panel: Panel, top: int) -> Axis:
    known = panel.y[np.isfinite(panel.y)]
    low, high = (float(known.min()), float(known.max())) if len(known) else (0.0, 1.0)
    room = max(0.06 * (high - low), (LEAST_SPAN - high + low) / 2)
    ends = (top, top + PANEL) if panel.down else (top + PANEL, top)
    return Axis(low - room, high + room, *ends)


def _lines(times_s: Floats, panel: Panel, x: Axis, y: Axis, hollow: Floats | None) -> list[str]:
    """Line and markers of each target; without `hollow` no markers."""
    parts = []
    for t, target in enumerate(TARGETS):
        places = np.column_stack([x.all(times_s), y.all(panel.y[:, t])])
        parts.append(f'<path class="line {target}" d="{path_data(places)}"/>')
        if hollow is None:
            continue
        for i in np.flatnonzero(np.isfinite(places[:, 1])).tolist():
            text = f"{LABELS[target]}, {times_s[i]:.2f} s: {panel.y[i, t]:.3f}"
            x_px, y_px = places[i].tolist()
            parts.append(marker(target, x_px, y_px, 2.4, text, hollow=bool(hollow[i, t])))
    return parts


def _lanes(spans: Sequence[Span], x: Axis, floor: int) -> list[str]:
    parts = [
        f'<text x="{LEFT - 7}" y="{floor + LANE * t + 13}" text-anchor="end">'
        f"{LABELS[target].removesuffix(' hand')}</text>"
        for t, target in enumerate(TARGETS)
    ]
    for span in spans:
        y = floor + LANE * TARGETS.index(span.target) + 4
        parts.append(
            f'<rect class="lane {span.target} {span.kind}" x="{x.at(span.start):.1f}" y="{y}" '
            f'width="{max(x.at(span.end) - x.at(span.start), 0.8):.1f}" height="{LANE - 8}">'
            f"<title>{escape(span.text)}</title></rect>"
        )
    return parts
