"""Curves of a probability over a parameter, an interval at every point."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from markupsafe import Markup, escape

from reports.gate.statistics import wilson
from reports.page.charts.grid import grid
from reports.page.charts.svg import BOTTOM, LEFT, RIGHT, TOP, WIDTH, Axis, svg
from reports.score.robustness import GOALS, Goal
from reports.stress.axes import DrawnAxis
from reports.stress.records import AxisRecord, MapRecord, OccludedRecord
from reports.stress.words import GOAL_SHORT, share_text
from reports.words import GOAL_WORDS

_HEIGHT = 300
_MARKS = {"swap": "M-5-5H5V5H-5Z", "head": "M0-6L6 5H-6Z", "lost": "M0-7L7 0 0 7-7 0Z"}


@dataclass(frozen=True)
class CurvePoint:
    """`hits` of n at a share of the x axis; where: its value in words; link: of an episode."""

    share: float
    hits: int
    n: int
    where: str
    link: str = ""


def speed_curves(
    record: MapRecord, links: dict[tuple[str, int], str], goals: Sequence[Goal] = GOALS
) -> Markup:
    """Draw P(failure) over the one parameter of a map, a line per goal that was ever failed."""
    x = DrawnAxis(record.x, LEFT + 8, WIDTH - RIGHT - 8)
    lines: dict[Goal, list[CurvePoint]] = {}
    for goal in goals:
        if goal == record.goal or any(cell.failures.get(goal, 0) for cell in record.cells):
            lines[goal] = [
                CurvePoint(
                    sum(cell.x) / 2,
                    cell.failures.get(goal, 0),
                    cell.n,
                    x.text(sum(cell.x) / 2),
                    links.get((cell.episode.label, cell.episode.seed), "") if cell.episode else "",
                )
                for cell in record.cells
                if cell.n
            ]
    return _chart(lines, x, f"{', '.join(GOAL_SHORT[g] for g in lines)} over {x.title}")


def occluded_curve(points: Sequence[OccludedRecord]) -> Markup:
    """Draw P(lost) over the frames for which no view showed a target."""
    most = max((point.frames for point in points), default=1)
    axis = AxisRecord(name="frames hidden at a stretch", unit="", low=0.0, high=float(most or 1))
    x = DrawnAxis(axis, LEFT + 8, WIDTH - RIGHT - 8)
    lines: dict[Goal, list[CurvePoint]] = {
        "lost": [
            CurvePoint(p.frames / (most or 1), p.lost, p.n, f"{p.frames} frames") for p in points
        ]
    }
    return _chart(lines, x, "P(lost) of a target over the frames for which it was hidden")


def _chart(lines: dict[Goal, list[CurvePoint]], x: DrawnAxis, label: str) -> Markup:
    intervals = [wilson(p.hits, p.n)[1] for line in lines.values() for p in line]
    top = next(t for t in (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0) if t >= max([*intervals, 0.005]))
    y = Axis(0.0, 100 * top, _HEIGHT - BOTTOM, TOP)
    titles = (x.title, "share of trials [%]")
    parts = [grid(x.ticks(), y.numbered(), titles, TOP, _HEIGHT - BOTTOM)]
    for n, (goal, points) in enumerate(lines.items()):
        parts += _line(goal, points, x, y, 2.5 * (n - (len(lines) - 1) / 2))
    parts += _legend(list(lines))
    return svg(parts, _HEIGHT, label)


def _line(
    goal: Goal, points: Sequence[CurvePoint], x: DrawnAxis, y: Axis, shift_px: float
) -> list[str]:
    """Line, intervals and marks of a goal, moved aside so that bars of two do not cover."""
    parts, path = [], ""
    for point in sorted(points, key=lambda p: p.share):
        at, p = x.at(point.share) + shift_px, point.hits / point.n
        low, high = wilson(point.hits, point.n)
        place = y.at(100 * p)
        path += f"{'L' if path else 'M'}{at:.1f} {place:.1f}"
        title = (
            f"{point.where}: {GOAL_WORDS[goal]} {point.hits} of {point.n}, "
            f"{share_text(low)} to {share_text(high)}"
        )
        mark = (
            f'<g class="goal {goal}"><path class="bar-line" d="M{at:.1f} {y.at(100 * low):.1f}'
            f'V{y.at(100 * high):.1f}"/><path class="dot-mark" d="{_MARKS[goal]}" '
            f'transform="translate({at:.1f} {place:.1f}) scale(.8)"/>'
            f"<title>{escape(title)}</title></g>"
        )
        if point.link:
            mark = f'<a href="{escape(point.link)}" aria-label="{escape(title)}">{mark}</a>'
        parts.append(mark)
    return [f'<path class="goal-line {goal}" d="{path}"/>', *parts]


def _legend(goals: Sequence[Goal]) -> list[str]:
    parts, at = [], float(LEFT)
    for goal in goals:
        parts.append(
            f'<g class="goal {goal}"><path class="goal-line {goal}" d="M{at:.0f} 14h26"/>'
            f'<path class="dot-mark" d="{_MARKS[goal]}" '
            f'transform="translate({at + 13:.0f} 14) scale(.8)"/></g>'
            f'<text x="{at + 32:.0f}" y="18">{GOAL_WORDS[goal]}</text>'
        )
        at += 46 + 7.8 * len(GOAL_WORDS[goal])
    return parts
