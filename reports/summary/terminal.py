"""The summary of a run for the terminal: tables of eighty columns.

Names are printed as they are, never as mark-up.
"""

from __future__ import annotations

from rich.table import Table
from rich.text import Text

from pjpdaf.targets import HEAD, TARGETS
from reports.summary.plain_table import plain_table
from reports.summary.tables import StageTimes, Summary, SummaryRow, time_text
from reports.summary.text import count, number, percent
from reports.words import ALL, LABELS


def scenario_table(summary: Summary) -> Table:
    """A row for each scenario: errors of head and hands, and what went wrong how often."""
    table = _empty_table(summary)
    table.add_column("scenario", no_wrap=True)
    for heading in ("n", "within\n100 mm", "head\nmm", "hands\nmm", "swapped", "lost"):
        table.add_column(heading, justify="right", no_wrap=True)
    table.add_column("ms a\nframe", justify="right", no_wrap=True)
    scenarios = summary.scenarios
    for times, rows in _blocks(summary):
        heads = [row for row in rows if row.target == TARGETS[HEAD]]
        everything = rows[-1]
        last = len(scenarios) != 1 and times is summary.total_times
        table.add_row(
            Text(everything.scenario),
            str(everything.episodes),
            percent(everything.within_100),
            number(heads[0].median_mm),
            number(summary.hands_mm.get(everything.scenario, float("nan"))),
            str(everything.swapped or 0),
            str(everything.lost),
            number(times.detect_ms + times.track_ms),
            end_section=bool(scenarios) and everything.scenario == scenarios[-1],
            style="bold" if last else "",
        )
    return table


def target_table(summary: Summary) -> Table:
    """A row for each target of each scenario, and all of them together."""
    table = _empty_table(summary)
    table.add_column("scenario,\nrender/detect/\ntrack", no_wrap=True)
    table.add_column("target", no_wrap=True)
    for heading in ("frames", "median\nmm", "90 %\nmm", "Err_acc\npx", "within\n100 mm"):
        table.add_column(heading, justify="right", no_wrap=True)
    for heading in ("ever\nswapped", "ever\nlost"):
        table.add_column(heading, justify="right", no_wrap=True)
    for times, rows in _blocks(summary):
        timed = f"{time_text(times).replace(' ', '')} ms"
        for row in rows:
            # Eighty columns: the times have no column of their own.
            left = {"head": Text(row.scenario), "right_hand": Text(timed, style="dim")}
            table.add_row(
                left.get(row.target, ""),
                LABELS[row.target].removesuffix(" hand"),
                str(row.frames),
                number(row.median_mm),
                number(row.p90_mm),
                number(row.err_acc_px),
                percent(row.within_100),
                "-" if row.swapped is None else f"{row.swapped}/{row.episodes}",
                f"{row.lost}/{row.episodes}",
                end_section=row.target == ALL,
                style="bold" if row.target == ALL else "",
            )
    return table


def _empty_table(summary: Summary) -> Table:
    table = plain_table(f"Run {summary.name}{_lag_text(summary)}")
    if summary.failures:
        table.caption = Text(f"{count(len(summary.failures), 'episode')} gave no result")
    return table


def _blocks(summary: Summary) -> list[tuple[StageTimes, list[SummaryRow]]]:
    """Times and rows of each scenario, and of all where there are several."""
    blocks = [(t, [r for r in summary.rows if r.scenario == t.scenario]) for t in summary.times]
    if len(blocks) != 1:
        blocks.append((summary.total_times, list(summary.total)))
    return blocks


def _lag_text(summary: Summary) -> str:
    lag = summary.lag_frames
    return f", estimates {count(lag, 'frame')} later" if lag else ""
