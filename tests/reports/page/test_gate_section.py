"""The gate on the page of a run: what is capped is marked, advice only where it is undecided."""

from dataclasses import replace

import pytest

from reports.gate.metrics import METRICS
from reports.gate.statistics import Difference
from reports.gate.verdict import Advice, EpisodeDifference, MetricVerdict, Verdict
from reports.page.gate_section import gate_section


@pytest.fixture
def verdict():
    difference = Difference(12, 9, 15, 24, 24)
    metrics = [MetricVerdict(m, "pass", 30.0, 42.0, difference, 0.0) for m in METRICS]
    metrics[0] = replace(metrics[0], verdict="fail", capped=2)
    return Verdict(
        base="main",
        new="mine",
        verdict="fail",
        identical=False,
        episodes=24,
        left_out=0,
        looks=1,
        alpha=0.05,
        metrics=tuple(metrics),
        groups=(),
        worst=(
            EpisodeDifference("drink", 3, 121.0, ("swapped",), "", capped=True),
            EpisodeDifference("cross", 0, 12.0, (), ""),
        ),
        notes=(),
        advice=Advice("few episodes", 9, 0.9, ("pjpdaf-bench run",)),
    )


def test_what_is_capped_is_marked(verdict):
    section = gate_section(verdict, ())
    assert [row.cells[2].text for row in section.table.rows[:2]] == ["+12* mm", "+12"]
    assert section.capped == ("2 of 24 differences of 3-D error are capped at 30 mm",)
    assert [w.text for w in section.worse] == [
        "drink, seed 3: at least +121.0 mm, swapped",
        "cross, seed 0: +12.0 mm",
    ]


def test_a_clear_verdict_needs_no_advice(verdict):
    assert gate_section(verdict, ()).advice == ()
    open_ = replace(verdict, verdict="inconclusive")
    assert gate_section(open_, ()).commands == ("pjpdaf-bench run",)
