"""A run with its figures for the main tables of the page."""

from __future__ import annotations

from dataclasses import dataclass

from markupsafe import Markup

from reports.page.charts.bars import stacked_bars
from reports.run.load import SavedRun
from reports.summary.budget import Budget, budget_of
from reports.summary.causes import blame_lines
from reports.summary.groups import GroupRow, group_rows, scenario_rows, whole_row
from reports.summary.tables import Summary, summarise


@dataclass(frozen=True, eq=False)
class RunReport:
    """A run with the figures of its main tables.

    groups, scenarios: rows of the main tables; total: all scenarios together; blame: lines such as
    "swaps: 8 association, 1 detections"; budget: the causes of the error, None where unknown.
    """

    run: SavedRun
    summary: Summary
    groups: tuple[GroupRow, ...]
    scenarios: tuple[GroupRow, ...]
    total: GroupRow
    blame: tuple[str, ...]
    budget: Budget | None
    budget_chart: Markup | None


def run_report(run: SavedRun) -> RunReport:
    """Summarise a run for the page."""
    budget = budget_of(run)
    return RunReport(
        run=run,
        summary=summarise(run),
        groups=group_rows(run),
        scenarios=scenario_rows(run),
        total=whole_row(run),
        blame=blame_lines(run.events),
        budget=budget,
        budget_chart=stacked_bars(budget.shares_mm) if budget is not None else None,
    )
