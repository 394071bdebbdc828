"""The outcome of a comparison: by metric, by group, by episode."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from reports.gate.metrics import Metric
from reports.gate.statistics import Difference

Outcome = Literal["pass", "fail", "inconclusive"]
_WORST_FIRST: tuple[Outcome, ...] = ("fail", "inconclusive")


@dataclass(frozen=True)
class MetricVerdict:
    """The verdict of one metric.

    base, new: median of the episodes, of shares the mean; difference: of the pairs, so not the one
    of these two; p: one-sided, adjusted after Holm (1 where nothing is estimated); capped: episodes
    whose difference counts as the metric's reach.
    """

    metric: Metric
    verdict: Outcome
    base: float
    new: float
    difference: Difference
    p: float
    capped: int = 0

    @property
    def better(self) -> bool:
        """Whether the new run is better beyond doubt."""
        return self.difference.high < 0


@dataclass(frozen=True)
class GroupDifference:
    """How one group of scenarios differs in one metric.

    base, new, difference, capped: as in `MetricVerdict`. verdict: the metric's, where this group
    is beyond the margin, else "pass".
    """

    group: str
    metric: Metric
    verdict: Outcome
    base: float
    new: float
    difference: float
    episodes: int
    capped: int = 0

    @property
    def beyond(self) -> bool:
        """Whether this group alone is worse by more than the margin; that decides nothing."""
        return self.difference > self.metric.margin


@dataclass(frozen=True)
class EpisodeDifference:
    """An episode that got worse: the growth of its error and its new events.

    capped: whether the error grew beyond what is measured; replay: the command that plays it again,
    "" where run.json does not have the request.
    """

    scenario: str
    seed: int
    error_mm: float
    events: tuple[str, ...]
    replay: str
    capped: bool = False


@dataclass(frozen=True)
class Advice:
    """Why a verdict is inconclusive, and what would decide it.

    seeds: of each scenario, in both runs, that decide each metric with the probability `power`;
    None: no number does, or none can be told. commands: that play these seeds and compare; empty
    where the runs' episodes cannot be played again.
    """

    reason: str
    seeds: int | None
    power: float | None
    commands: tuple[str, ...]


@dataclass(frozen=True)
class Verdict:
    """The outcome of a comparison.

    identical: all results are the same. episodes: pairs; left_out: of these, without a
    result in the base, and so only in the metric "failed". looks: how many times the data may be
    judged; alpha: the share of false alarms allowed this time. notes: other differences between
    the runs. advice: of an inconclusive verdict.
    """

    base: str
    new: str
    verdict: Outcome
    identical: bool
    episodes: int
    left_out: int
    looks: int
    alpha: float
    metrics: tuple[MetricVerdict, ...]
    groups: tuple[GroupDifference, ...]
    worst: tuple[EpisodeDifference, ...]
    notes: tuple[str, ...]
    advice: Advice | None = None


def worst_outcome(outcomes: Sequence[Outcome]) -> Outcome:
    """The worst of several outcomes: fail before inconclusive before pass."""
    for outcome in _WORST_FIRST:
        if outcome in outcomes:
            return outcome
    return "pass"
