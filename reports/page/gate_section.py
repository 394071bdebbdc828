"""The gate's verdict against a baseline, on the page of the run that it judges."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from reports.gate.advice import advice_lines
from reports.gate.text import (
    cap_text,
    difference_text,
    interval_text,
    number,
    outcome_text,
    unit_text,
    verdict_sentence,
)
from reports.gate.verdict import EpisodeDifference, MetricVerdict, Verdict
from reports.page.figure_table import Cell, Column, FigureRow, FigureTable, cells, heads
from reports.page.run_entries import RunEntry

OUTCOMES = {"pass": "good", "fail": "bad", "inconclusive": "none"}
LEADS = {"pass": "Gate passed", "fail": "Gate failed", "inconclusive": "Gate undecided"}


@dataclass(frozen=True)
class WorseEpisode:
    """An episode that got worse; address: of the episode in the page, "" without it."""

    text: str
    address: str


@dataclass(frozen=True)
class GateSection:
    """A verdict on the page.

    outcome: class of its colour; sentence: the verdict in words; advice: why it is inconclusive;
    commands: that would decide it; capped: what the stars of the table stand for.
    """

    base: str
    outcome: str
    sentence: str
    table: FigureTable
    worse: tuple[WorseEpisode, ...]
    advice: tuple[str, ...]
    commands: tuple[str, ...]
    capped: tuple[str, ...]
    notes: tuple[str, ...]


def gate_section(verdict: Verdict, entries: Sequence[RunEntry]) -> GateSection:
    """The section of a verdict. entries: the episodes of the run that it judges."""
    advice = verdict.advice if verdict.verdict == "inconclusive" else None
    by_key = {(entry.scenario, entry.seed): entry for entry in entries}
    return GateSection(
        base=verdict.base,
        outcome=OUTCOMES[verdict.verdict],
        sentence=verdict_sentence(verdict, LEADS[verdict.verdict], lambda metric: metric.short),
        table=FigureTable(
            anchor="by-metric",
            label="Metrics against the baseline",
            first="Metric",
            columns=heads(_columns(verdict)),
            rows=tuple(
                FigureRow(m.metric.meaning, cells(_columns(verdict), m)) for m in verdict.metrics
            ),
        ),
        worse=tuple(
            WorseEpisode(
                _worse_text(e),
                f"#play={entry.key}@{entry.worst_frame}"
                if (entry := by_key.get((e.scenario, e.seed)))
                else "",
            )
            for e in verdict.worst
        ),
        advice=advice_lines(advice) if advice is not None else (),
        commands=advice.commands if advice is not None else (),
        capped=tuple(filter(None, (cap_text(m, m.metric.short) for m in verdict.metrics))),
        notes=verdict.notes,
    )


def _worse_text(episode: EpisodeDifference) -> str:
    least = "at least " if episode.capped else ""
    grown = f"{episode.scenario}, seed {episode.seed}: {least}{episode.error_mm:+.1f} mm"
    return ", ".join([grown, *episode.events])


def _columns(verdict: Verdict) -> tuple[Column[MetricVerdict], ...]:
    share = f"{100 * (1 - verdict.alpha):.4g} % interval"
    return (
        Column("Baseline", lambda m: _value(m, m.base)),
        Column("This run", lambda m: _value(m, m.new)),
        Column(
            "Difference",
            lambda m: Cell(difference_text(m) + unit_text(m.metric), m.difference.mean),
        ),
        Column("Verdict", lambda m: Cell(outcome_text(m), bad=m.verdict == "fail")),
        Column(share, lambda m: Cell(interval_text(m), m.difference.high), extra=True),
        Column("Margin", lambda m: _value(m, m.metric.margin), extra=True),
    )


def _value(judged: MetricVerdict, value: float) -> Cell:
    return Cell(number(value) + unit_text(judged.metric), value)
