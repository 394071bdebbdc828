"""Causes of failure and of error in words: stages to blame, and the error budget in a line."""

from __future__ import annotations

import pandas as pd

from pjpdaf.targets import TARGETS
from reports.summary.budget import Budget
from reports.summary.text import number

_PLURALS = {"swap": "swaps", "capture": "captures", "lost": "losses"}
_STAGES = {"none": "no single stage", "process": "process model"}


def stage_text(stage: str) -> str:
    """The stage at fault for an event in words."""
    return _STAGES.get(stage, stage)


def blame_lines(events: pd.DataFrame) -> tuple[str, ...]:
    """Count the stages at fault, a line per kind of event; empty where none is known."""
    lines = []
    for kind, plural in _PLURALS.items():
        stages = events.loc[(events["kind"] == kind) & (events["blame"] != ""), "blame"]
        if len(stages):
            counts = [f"{n} {stage_text(str(stage))}" for stage, n in stages.value_counts().items()]
            lines.append(f"{plural}: {', '.join(counts)}")
    return tuple(lines)


def budget_line(budget: Budget) -> str:
    """The mean error of all targets [mm] and the share of each cause, such as "detector +3.1"."""
    total = sum(budget.frames.values())

    def mean(values_mm: dict[str, float]) -> float:
        return sum(values_mm[target] * budget.frames[target] for target in TARGETS) / total

    error = sum(map(mean, budget.shares_mm.values()))
    shares = [f"{cause} {mean(mm):+.1f}" for cause, mm in budget.shares_mm.items()]
    return f"mean error {number(error)} mm: {'; '.join(shares)}"
