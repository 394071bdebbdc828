"""A section of the page for each scenario: rows by target, episodes, events."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from markupsafe import Markup

from reports.page.charts.speed_chart import speed_chart
from reports.page.figure_table import FigureTable
from reports.page.run_entries import RunEntry
from reports.page.run_report import RunReport
from reports.page.summary_tables import target_table
from reports.summary.causes import stage_text
from reports.summary.tables import StageTimes, Summary, SummaryRow
from reports.words import event_text

MAX_EVENTS = 200


@dataclass(frozen=True)
class EventLine:
    """A row of a scenario's table of events; key: of its episode; blame: the stage at fault."""

    key: str
    run: str
    seed: int
    text: str
    first_frame: int
    last_frame: int
    start_s: float
    duration_s: float
    ended: bool
    blame: str


@dataclass(frozen=True, eq=False)
class ScenarioSection:
    """A scenario on the page.

    blocks: (run, rows, times); table: the rows by target; speeds: (run, "" where there is one,
    speed curve).
    """

    anchor: str
    name: str
    blocks: tuple[tuple[Summary, tuple[SummaryRow, ...], StageTimes], ...]
    table: FigureTable
    entries: tuple[RunEntry, ...]
    speeds: tuple[tuple[str, Markup], ...]
    events: tuple[EventLine, ...]
    more_events: int


def scenario_sections(
    reports: Sequence[RunReport], entries: Sequence[RunEntry], names: Sequence[str]
) -> list[ScenarioSection]:
    """Make the section of each of these scenarios, in this order."""
    sections = []
    for n, name in enumerate(names):
        speeds: list[tuple[str, Markup]] = []
        events: list[EventLine] = []
        blocks = []
        for r, report in enumerate(reports):
            run, summary = report.run, report.summary
            rows = tuple(row for row in summary.rows if row.scenario == name)
            if not rows:
                continue
            times = next(t for t in summary.times if t.scenario == name)
            blocks.append((summary, rows, times))
            curve = speed_chart(run.frames[run.frames["scenario"] == name])
            if curve is not None:
                speeds.append((run.name if len(reports) > 1 else "", curve))
            rows_of_events = run.events[run.events["scenario"] == name].to_dict("records")
            events += [_event_line(f"{r}-{n}", run.name, event) for event in rows_of_events]
        sections.append(
            ScenarioSection(
                anchor=f"scenario-{n}",
                name=name,
                blocks=tuple(blocks),
                table=target_table(
                    f"scenario-{n}-targets",
                    f"{name} by target",
                    [(s.name if len(reports) > 1 else "", rows) for s, rows, _ in blocks],
                ),
                entries=tuple(e for e in entries if e.scenario == name),
                speeds=tuple(speeds),
                events=tuple(events[:MAX_EVENTS]),
                more_events=max(0, len(events) - MAX_EVENTS),
            )
        )
    return sections


def _event_line(prefix: str, run: str, event: Mapping[Any, Any]) -> EventLine:
    return EventLine(
        key=f"{prefix}-{event['seed']}",
        run=run,
        seed=int(event["seed"]),
        text=event_text(event),
        first_frame=int(event["first_frame"]),
        last_frame=int(event["last_frame"]),
        start_s=float(event["start_s"]),
        duration_s=float(event["duration_s"]),
        ended=bool(event["ended"]),
        blame=stage_text(str(event["blame"])),
    )
