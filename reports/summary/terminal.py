"""The summary of a run for the terminal: tables of eighty columns, and wider ones.

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


def scenario_table(summary: Summary, *, wide: bool = False) -> Table:
    """A row for each scenario: errors of head and hands, and what went wrong how often.

    wide: with more of the errors, and the time of each stage.
    """
    table = _empty_table(summary)
    table.add_column("scenario", no_wrap=True)
    errors = ("within\n50 mm", "90 %\nmm", "Err_acc\npx") if wide else ()
    events = ("swapped", "captured", "lost") if wide else ("swapped", "lost")
    times = ("render\nms", "detect\nms", "track\nms") if wide else ()
    _add_figures(table, "n", *(("frames",) if wide else ()), "within\n100 mm", "head\nmm")
    _add_figures(table, "hands\nmm", *errors, *events, "ms a\nframe", *times)
    scenarios = summary.scenarios
    for times_ms, rows in _blocks(summary):
        head = next(row for row in rows if row.target == TARGETS[HEAD])
        every = rows[-1]
        hands_mm = summary.hands_mm.get(every.scenario, float("nan"))
        more = (percent(every.within_50), number(every.p90_mm), number(every.err_acc_px))
        stages = (times_ms.render_ms, times_ms.detect_ms, times_ms.track_ms)
        table.add_row(
            Text(every.scenario),
            str(every.episodes),
            *((str(head.frames),) if wide else ()),
            percent(every.within_100),
            number(head.median_mm),
            number(hands_mm),
            *(more if wide else ()),
            str(every.swapped or 0),
            *((str(every.captured),) if wide else ()),
            str(every.lost),
            number(times_ms.detect_ms + times_ms.track_ms),
            *(map(number, stages) if wide else ()),
            end_section=bool(scenarios) and every.scenario == scenarios[-1],
            style="bold" if len(scenarios) != 1 and times_ms is summary.total_times else "",
        )
    return table


def target_table(summary: Summary, *, wide: bool = False) -> Table:
    """A row for each target of each scenario, and all of them together.

    wide: with more of the errors, and columns for the time of each stage, for which eighty columns
    have no room.
    """
    table = _empty_table(summary)
    name = "scenario" if wide else "scenario,\nrender/detect/\ntrack"
    for heading in (name, "target"):
        table.add_column(heading, no_wrap=True)
    errors = ("within\n50 mm",) if wide else ()
    events = ("ever\ncaptured",) if wide else ()
    times = ("render\nms", "detect\nms", "track\nms") if wide else ()
    _add_figures(table, "frames", "median\nmm", "90 %\nmm", "Err_acc\npx", *errors)
    _add_figures(table, "within\n100 mm", "ever\nswapped", *events, "ever\nlost", *times)
    for times_ms, rows in _blocks(summary):
        timed = "" if wide else f"{time_text(times_ms).replace(' ', '')} ms"
        stages = (times_ms.render_ms, times_ms.detect_ms, times_ms.track_ms)
        for row in rows:
            left = {"head": Text(row.scenario), "right_hand": Text(timed, style="dim")}
            table.add_row(
                left.get(row.target, ""),
                LABELS[row.target].removesuffix(" hand"),
                str(row.frames),
                number(row.median_mm),
                number(row.p90_mm),
                number(row.err_acc_px),
                *((percent(row.within_50),) if wide else ()),
                percent(row.within_100),
                "-" if row.swapped is None else f"{row.swapped}/{row.episodes}",
                *((f"{row.captured}/{row.episodes}",) if wide else ()),
                f"{row.lost}/{row.episodes}",
                *([number(ms) if row.target == ALL else "" for ms in stages] if wide else ()),
                end_section=row.target == ALL,
                style="bold" if row.target == ALL else "",
            )
    return table


def _add_figures(table: Table, *headings: str) -> None:
    for heading in headings:
        table.add_column(heading, justify="right", no_wrap=True)


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
