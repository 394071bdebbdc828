"""The tables of figures of the page's summary, and those by target of a scenario."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from reports.page.figure_table import (
    GROUP_COLUMNS,
    TARGET_COLUMNS,
    FigureRow,
    FigureTable,
    cells,
    heads,
)
from reports.page.run_report import RunReport
from reports.summary.groups import GroupRow
from reports.summary.tables import SummaryRow
from reports.words import ALL, LABELS

_NAMES_OF_GROUPS = tuple(c for c in GROUP_COLUMNS if c.words != "Group")


def group_table(reports: Sequence[RunReport]) -> FigureTable:
    """A row for each group of scenarios and run, all scenarios at the foot."""
    names = dict.fromkeys(row.name for report in reports for row in report.groups)
    pairs = [(r, row) for name in names for r in reports for row in r.groups if row.name == name]
    several = len(reports) > 1

    def line(report: RunReport, row: GroupRow, name: str) -> FigureRow:
        run = report.run.name if several else ""
        return FigureRow(name, cells(_NAMES_OF_GROUPS, row), run=run)

    return FigureTable(
        anchor="by-group",
        label="Figures by group of scenarios",
        first="Group",
        columns=heads(_NAMES_OF_GROUPS),
        rows=tuple(line(report, row, row.name) for report, row in pairs),
        total=tuple(line(report, report.total, "All") for report in reports),
    )


def scenario_table(reports: Sequence[RunReport], anchors: Mapping[str, str]) -> FigureTable:
    """A row for each scenario and run. anchors: of the scenarios' sections, in their order."""
    several = len(reports) > 1
    return FigureTable(
        anchor="by-scenario",
        label="Figures by scenario",
        first="Scenario",
        columns=heads(GROUP_COLUMNS),
        rows=tuple(
            FigureRow(
                name,
                cells(GROUP_COLUMNS, row),
                anchor=anchor,
                run=report.run.name if several else "",
            )
            for name, anchor in anchors.items()
            for report in reports
            for row in report.scenarios
            if row.name == name
        ),
    )


def target_table(
    anchor: str, label: str, blocks: Sequence[tuple[str, Sequence[SummaryRow]]]
) -> FigureTable:
    """A row for each target. blocks: (run, rows), run "" where there is one."""
    return FigureTable(
        anchor=anchor,
        label=label,
        first="Target",
        columns=heads(TARGET_COLUMNS),
        rows=tuple(
            FigureRow(
                LABELS[row.target],
                cells(TARGET_COLUMNS, row),
                run=run,
                dot="" if row.target == ALL else row.target,
                pooled=row.target == ALL,
            )
            for run, rows in blocks
            for row in rows
        ),
    )
