"""The catalogue as plain text, for `scenarios list`."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator

from scenarios.spec.names import load_scenario, load_suite, scenario_names, suite_names
from scenarios.spec.scenario import Scenario

WIDTH = 100  # of a pipe, and at most
LEAST_TEXT = 34  # columns for the last cell; where there are fewer it goes below
INDENT = 4
HEADING = ("name", "group", "frames", "T", "what")  # 150 x 3: at 3 a second; T: of the thesis


def catalogue_lines(width: int = WIDTH) -> Iterator[str]:
    """Yield a heading, then every scenario and every suite; no word is broken.

    width: of a line, WIDTH at most. The last column goes on below itself, so that only a name
    stands at the start of a line.
    """
    width = min(width, WIDTH)
    rows = [HEADING, *map(_scenario_row, map(load_scenario, scenario_names()))]
    rows += [_suite_row(name) for name in suite_names()]
    widths = [max(len(row[column]) for row in rows) for column in range(len(HEADING) - 1)]
    indent = sum(widths) + 2 * len(widths)
    below = width - indent < LEAST_TEXT
    for row in rows:
        start = "".join(cell.ljust(w + 2) for cell, w in zip(row[:-1], widths, strict=True))
        if below:
            yield start.rstrip()
        yield from textwrap.wrap(
            row[-1],
            width,
            initial_indent=" " * INDENT if below else start,
            subsequent_indent=" " * (INDENT if below else indent),
            break_on_hyphens=False,
            break_long_words=False,
        )


def _scenario_row(scenario: Scenario) -> tuple[str, ...]:
    length = f"{scenario.frames} x {scenario.fps:g}"
    if scenario.rates:
        length = f"{scenario.frames} x {min(scenario.rates):g}-{max(scenario.rates):g}"
    thesis = "T" if scenario.thesis else ""
    return scenario.name, scenario.group, length, thesis, scenario.summary


def _suite_row(name: str) -> tuple[str, ...]:
    suite = load_suite(name)
    members = ", ".join(entry.label or entry.scenario for entry in suite.scenarios)
    return name, "suite", f"{suite.seeds} seed{'s' if suite.seeds != 1 else ''}", "", members
