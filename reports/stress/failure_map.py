"""The failure map: a cell's colour is the share of its trials that failed; a click plays one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from markupsafe import Markup, escape

from reports.gate.statistics import wilson
from reports.page.charts.svg import WIDTH, svg
from reports.score.robustness import Goal
from reports.stress.axes import DrawnAxis
from reports.stress.records import CellRecord, MapRecord
from reports.stress.words import share_text
from reports.words import GOAL_WORDS

_LEFT, _RIGHT, _TOP, _BOTTOM = 62, 14, 10, 84
_SIDE = WIDTH - _LEFT - _RIGHT
_ROOM_PX = 26.0  # of a cell that has its numbers written in it


@dataclass(frozen=True)
class DrawnCell:
    """A cell to draw. share: 0-1 of the colour, negative for the second one; inside: its text."""

    cell: CellRecord
    share: float
    inside: str
    title: str


def failure_map(record: MapRecord, goal: Goal, links: Mapping[tuple[str, int], str]) -> Markup:
    """Draw a map of two parameters. links: address of an episode by label and seed."""
    x, y = _axes(record)
    cells = []
    for cell in record.cells:
        failures = cell.failures.get(goal, 0)
        low, high = wilson(failures, cell.n)
        title = (
            f"{_place(cell, x, y)}: {GOAL_WORDS[goal]} in {failures} of {cell.n} trials, "
            f"95 % interval {share_text(low)} to {share_text(high)}"
        )
        share = failures / cell.n if cell.n else 0.0
        cells.append(DrawnCell(cell, share, f"{failures}/{cell.n}" if cell.n else "–", title))
    elements = [*_cells(cells, x, y, links), *_contour(record.cells, goal, record.level, x, y)]
    legend = [
        *_legend(("0", "1"), "of the trials failed"),
        f'<path class="contour" d="M{WIDTH - 150} 0h26" transform="translate(0 {_height() - 13})"/>'
        f'<text x="{WIDTH - 118}" y="{_height() - 9}">contour at {record.level:g}</text>',
    ]
    label = f"{GOAL_WORDS[goal]} over {x.title} and {y.title}, {record.family}"
    return svg([*elements, *_frame(x, y), *legend], _height(), label)


def difference_map(a: MapRecord, b: MapRecord, goal: Goal, names: tuple[str, str]) -> Markup:
    """Draw P(b) - P(a) over the cells that two maps share: where the second fails more, red."""
    x, y = _axes(a)
    others = {(cell.x, cell.y): cell for cell in b.cells}
    cells = []
    for cell in a.cells:
        other = others.get((cell.x, cell.y))
        if other is None or not (cell.n and other.n):
            continue
        k, m = cell.failures.get(goal, 0), other.failures.get(goal, 0)
        difference = m / other.n - k / cell.n
        title = f"{_place(cell, x, y)}: {names[0]} {k} of {cell.n}, {names[1]} {m} of {other.n}"
        cells.append(DrawnCell(cell, difference, f"{100 * difference:+.0f}", title))
    legend = _legend((f"{names[0]} fails more", f"{names[1]} fails more"), "", "ramp-two")
    label = f"Difference of {GOAL_WORDS[goal]} over {x.title} and {y.title}, {a.family}"
    return svg([*_cells(cells, x, y, {}), *_frame(x, y), *legend], _height(), label)


def _axes(record: MapRecord) -> tuple[DrawnAxis, DrawnAxis]:
    assert record.y is not None, "a map of two parameters"
    x = DrawnAxis(record.x, _LEFT, _LEFT + _SIDE)
    return x, DrawnAxis(record.y, _TOP + _SIDE, _TOP)


def _height() -> int:
    return _TOP + _SIDE + _BOTTOM


def _place(cell: CellRecord, x: DrawnAxis, y: DrawnAxis) -> str:
    middle = [(ends[0] + ends[1]) / 2 for ends in (cell.x, cell.y)]
    return f"{x.record.name} {x.text(middle[0])}, {y.record.name} {y.text(middle[1])}"


def _cells(
    cells: Sequence[DrawnCell],
    x: DrawnAxis,
    y: DrawnAxis,
    links: Mapping[tuple[str, int], str],
) -> list[str]:
    elements = []
    for drawn in cells:
        cell = drawn.cell
        x0, x1 = x.at(cell.x[0]), x.at(cell.x[1])
        y1, y0 = y.at(cell.y[0]), y.at(cell.y[1])
        kind = "cell" if drawn.share >= 0 else "cell less"
        kind += "" if cell.n else " unplayed"
        body = (
            f'<rect class="{kind}" style="--p: {100 * abs(drawn.share):.0f}%" x="{x0:.1f}" '
            f'y="{y0:.1f}" width="{x1 - x0:.1f}" height="{y1 - y0:.1f}">'
            f"<title>{escape(drawn.title)}</title></rect>"
        )
        if min(x1 - x0, 1.6 * (y1 - y0)) >= _ROOM_PX and drawn.share:
            strong = " strong" if abs(drawn.share) > 0.55 else ""
            body += (
                f'<text class="in-cell{strong}" x="{(x0 + x1) / 2:.1f}" '
                f'y="{(y0 + y1) / 2 + 4:.1f}" text-anchor="middle">{escape(drawn.inside)}</text>'
            )
        key = cell.episode
        link = links.get((key.label, key.seed)) if key is not None else None
        if link is not None:
            body = f'<a href="{escape(link)}" aria-label="{escape(drawn.title)}">{body}</a>'
        elements.append(body)
    return elements


def _contour(
    cells: Sequence[CellRecord], goal: Goal, level: float, x: DrawnAxis, y: DrawnAxis
) -> list[str]:
    """The edges between cells on either side of the level."""
    above = [cell.n > 0 and cell.failures.get(goal, 0) / cell.n >= level for cell in cells]
    lines = []
    for i, a in enumerate(cells):
        for j, b in enumerate(cells):
            if above[i] == above[j] or not (a.n and b.n):
                continue
            if abs(a.x[1] - b.x[0]) < 1e-9:
                low, high = max(a.y[0], b.y[0]), min(a.y[1], b.y[1])
                if high - low > 1e-9:
                    lines.append(f"M{x.at(a.x[1]):.1f} {y.at(low):.1f}V{y.at(high):.1f}")
            if abs(a.y[1] - b.y[0]) < 1e-9:
                low, high = max(a.x[0], b.x[0]), min(a.x[1], b.x[1])
                if high - low > 1e-9:
                    lines.append(f"M{x.at(low):.1f} {y.at(a.y[1]):.1f}H{x.at(high):.1f}")
    return [f'<path class="contour" d="{"".join(lines)}"/>'] if lines else []


def _frame(x: DrawnAxis, y: DrawnAxis) -> list[str]:
    bottom = _TOP + _SIDE
    parts = [
        f'<rect class="box" x="{_LEFT}" y="{_TOP}" width="{_SIDE}" height="{_SIDE}"/>',
        f'<text x="{_LEFT + _SIDE / 2}" y="{bottom + 38}" text-anchor="middle">'
        f"{escape(x.title)}</text>",
        f'<text transform="translate(14 {_TOP + _SIDE / 2}) rotate(-90)" text-anchor="middle">'
        f"{escape(y.title)}</text>",
    ]
    for at, text in x.ticks():
        parts.append(
            f'<path class="tick" d="M{at:.1f} {bottom}v4"/><text x="{at:.1f}" y="{bottom + 18}" '
            f'text-anchor="middle">{escape(text)}</text>'
        )
    for at, text in y.ticks():
        parts.append(
            f'<path class="tick" d="M{_LEFT} {at:.1f}h-4"/><text x="{_LEFT - 8}" y="{at + 4:.1f}" '
            f'text-anchor="end">{escape(text)}</text>'
        )
    return parts


def _legend(ends: tuple[str, str], title: str, kind: str = "ramp-one") -> list[str]:
    """A ramp of the colours with its ends, in steps: an SVG gradient knows no colour of CSS."""
    y, x0, step, n = _height() - 22, _LEFT + (14 if kind == "ramp-one" else 130), 11, 11
    parts = []
    for i in range(n):
        share = i / (n - 1) if kind == "ramp-one" else 2 * i / (n - 1) - 1
        less = " less" if share < 0 else ""
        parts.append(
            f'<rect class="cell{less}" style="--p: {100 * abs(share):.0f}%" x="{x0 + step * i}" '
            f'y="{y}" width="{step}" height="12"/>'
        )
    parts += [
        f'<text x="{x0 - 6}" y="{y + 11}" text-anchor="end">{escape(ends[0])}</text>',
        f'<text x="{x0 + step * n + 6}" y="{y + 11}">{escape(ends[1])}</text>',
        f'<text class="soft" x="{x0 + step * n + 22}" y="{y + 11}">{escape(title)}</text>',
    ]
    return parts
