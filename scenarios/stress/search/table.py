"""The table of distinct failures for the terminal."""

from __future__ import annotations

from collections.abc import Sequence

from rich.table import Table
from rich.text import Text

from reports.summary.plain_table import plain_table
from reports.words import MEASURE_WORDS
from scenarios.stress.confirm import Counterexample


def failure_table(family: str, found: Sequence[Counterexample]) -> Table:
    """A row for each distinct failure; of a confirmed one rho, severity, blame of the pictures."""
    table = plain_table(f"Failures of {family}")
    table.add_column("event", overflow="fold")
    table.add_column("what matters", overflow="fold", ratio=1)
    for heading in ("rho", "bad\nframes", "fails\nagain"):
        table.add_column(heading, justify="right", no_wrap=True)
    table.add_column("in\nfull", no_wrap=True)
    table.add_column("blame", overflow="fold")
    for one in found:
        robustness = one.result.robustness
        rho = "-" if robustness is None else f"{robustness.measures[one.measure]:+.2f}"
        table.add_row(
            MEASURE_WORDS[one.measure],
            Text(one.failure.words),
            rho,
            f"{100 * one.result.severity:.0f} %",
            one.survival.text if one.survival.of else "-",
            _in_full(one),
            one.blame or "-",
        )
    return table


def _in_full(one: Counterexample) -> str:
    if one.full is None:
        return "-"
    if one.full.result.robustness is None:
        return "none"  # no result
    return "fails" if one.confirmed else "passes"
