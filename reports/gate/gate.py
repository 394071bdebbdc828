"""The gate: is a new run worse than its base? A verdict per metric, paired episode by episode."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd

from pjpdaf.arrays import Floats
from pjpdaf.errors import InfrastructureError
from reports.gate.advice import advice_of
from reports.gate.metrics import METRICS, Metric, with_margins
from reports.gate.pairing import CAP_MM, check_comparable, episode_values, notes_of, same_results
from reports.gate.replay import replay_command
from reports.gate.statistics import Difference, clustered_bootstrap, holm, mcnemar, sign_flip
from reports.gate.verdict import (
    EpisodeDifference,
    GroupDifference,
    MetricVerdict,
    Outcome,
    Verdict,
    worst_outcome,
)
from reports.run.failures import failures_of
from reports.run.load import SavedRun
from reports.summary.text import count

ALPHA = 0.05
BUDGET = 0.05  # share of episodes that the base may lack results of
MOST_WORST = 10


def compare(
    base: SavedRun,
    new: SavedRun,
    margins: Mapping[str, float] | None = None,
    seed: int = 0,
    looks: int = 1,
) -> Verdict:
    """Judge `new` against `base`.

    A metric fails where its mean difference is more than the margin and significantly above 0: the
    interval (clustered bootstrap) and, after Holm over the metrics, an exact test (episodes: sign
    flips; events: McNemar). It passes where the interval's upper end is within the margin; else it
    is inconclusive. One failure fails all. looks: where the same data are judged again with more
    episodes, how often at most; each look then has its share of 5 % (Bonferroni).

    Raises NotComparable, BenchError for a margin of no metric, InfrastructureError where the base
    lacks too many results.
    """
    check_comparable(base, new)
    metrics = with_margins(margins or {})
    before, after = episode_values(base), episode_values(new)
    known = ~before["failed"].to_numpy(dtype=bool)
    check_base(base, before)
    alpha = ALPHA / looks
    rng = np.random.default_rng(seed)
    judged: list[MetricVerdict] = []
    p_values: list[float] = []
    for metric in metrics:
        rows = np.ones(len(known), dtype=bool) if metric.counted else known
        old, now = before[rows], after[rows]
        difference, p = _difference(metric, old, now, rng, alpha)
        was, is_now = _typical(metric, old), _typical(metric, now)
        capped = _capped(metric, old, now)
        judged.append(MetricVerdict(metric, "pass", was, is_now, difference, p, capped))
        p_values += [] if metric.counted else [p]
    adjusted = iter(holm(p_values))
    judged = [m if m.metric.counted else replace(m, p=next(adjusted)) for m in judged]
    judged = [replace(m, verdict=_outcome(m, alpha)) for m in judged]
    return Verdict(
        base=base.name,
        new=new.name,
        verdict=worst_outcome([m.verdict for m in judged]),
        identical=same_results(base, new),
        episodes=len(before),
        left_out=int((~known).sum()),
        looks=looks,
        alpha=alpha,
        metrics=tuple(judged),
        groups=_groups(judged, before, after, known),
        worst=_worst(before, after, new.meta),
        notes=notes_of(base, new),
        advice=advice_of(base, new, judged, alpha),
    )


def _typical(metric: Metric, values: pd.DataFrame) -> float:
    """Median of the episodes; of shares, whose median says little, the mean."""
    column = values[metric.name].to_numpy(dtype=np.float64)
    return float(column.mean() if metric.unit == "1" else np.median(column))


def _changes(metric: Metric, before: pd.DataFrame, after: pd.DataFrame) -> Floats:
    """Per episode, new - base, within reach."""
    old, now = (v[metric.name].to_numpy(dtype=np.float64) for v in (before, after))
    # A cured failure does not make up for a new failure.
    least = 0.0 if metric.counted else -metric.reach
    return np.asarray(np.clip(now - old, least, metric.reach))


def _capped(metric: Metric, before: pd.DataFrame, after: pd.DataFrame) -> int:
    """Episodes whose difference counts as the metric's reach."""
    old, now = (v[metric.name].to_numpy(dtype=np.float64) for v in (before, after))
    return int((np.abs(now - old) > metric.reach).sum())


def check_base(base: SavedRun, values: pd.DataFrame) -> None:
    """Raise InfrastructureError where a run lacks too many results to be compared with.

    values: of its episodes (`episode_values`).
    """
    known = ~values["failed"].to_numpy(dtype=bool)
    absent = int((~known).sum())
    # Seeds that cannot be posed fail in both; they are no fault of the machine.
    rows = base.episodes[base.episodes["failure"] != ""]
    broken = [failure for failure in failures_of(base) if failure.kind != "unposable"]
    if absent == len(known) or len(broken) > BUDGET * len(known):
        first = rows.iloc[0]
        raise InfrastructureError(
            f"{base.folder}: {absent} of {count(len(known), 'episode')} have no result, the first: "
            f"{first['scenario']} seed {first['seed']}: {first['failure']}; play the base again"
        )


def _difference(
    metric: Metric,
    before: pd.DataFrame,
    after: pd.DataFrame,
    rng: np.random.Generator,
    alpha: float,
) -> tuple[Difference, float]:
    """The paired difference, and the p-value of "no worse"."""
    changes = _changes(metric, before, after)
    draws = before["draw"].tolist()
    if metric.counted:
        mean = float(changes.mean())
        return Difference(mean, mean, mean, len(changes), len(set(draws))), 1.0
    difference = clustered_bootstrap(
        changes, draws, before["group"].tolist(), rng, level=1.0 - alpha
    )
    if metric.unit == "1":
        difference = _of_shares(difference)
    return difference, mcnemar(changes, draws) if metric.event else sign_flip(changes, draws, rng)


def _of_shares(difference: Difference) -> Difference:
    """Without what a difference of two shares cannot be; an open end stays open."""
    if not np.isfinite(difference.low):
        return difference
    return replace(difference, low=max(difference.low, -1.0), high=min(difference.high, 1.0))


def _outcome(judged: MetricVerdict, alpha: float) -> Outcome:
    difference, margin = judged.difference, judged.metric.margin
    if judged.metric.counted:
        return "fail" if difference.mean > margin else "pass"
    if difference.mean > margin and difference.low > 0 and judged.p < alpha:
        return "fail"
    return "pass" if difference.high <= margin else "inconclusive"


def _groups(
    judged: Sequence[MetricVerdict], before: pd.DataFrame, after: pd.DataFrame, known: np.ndarray
) -> tuple[GroupDifference, ...]:
    """Per group and metric; where a metric fails, the groups that are beyond its margin do."""
    out = []
    groups = before["group"].to_numpy()
    for group in sorted(set(groups.tolist())):
        for verdict in judged:
            rows = (groups == group) & (known | verdict.metric.counted)
            if not rows.any():
                continue
            old, now = before[rows], after[rows]
            group_difference = GroupDifference(
                group=group,
                metric=verdict.metric,
                verdict="pass",
                base=_typical(verdict.metric, old),
                new=_typical(verdict.metric, now),
                difference=float(_changes(verdict.metric, old, now).mean()),
                capped=_capped(verdict.metric, old, now),
                episodes=int(rows.sum()),
            )
            out.append(
                replace(
                    group_difference, verdict=verdict.verdict if group_difference.beyond else "pass"
                )
            )
    return tuple(out)


def _worst(
    before: pd.DataFrame, after: pd.DataFrame, meta: Mapping[str, Any]
) -> tuple[EpisodeDifference, ...]:
    """The episodes that got worse, the worst first: new events before grown errors."""
    events = [metric.name for metric in METRICS if metric.event]
    worse = []
    for key, old, now in zip(
        before.index, before.to_dict("records"), after.to_dict("records"), strict=True
    ):
        name, seed = str(key[0]), int(key[1])
        new_events = tuple(event for event in events if now[event] and not old[event])
        grown = float(now["error_mm"] - old["error_mm"])
        if new_events or grown > 0:
            replay = replay_command(meta, name, seed)
            capped = bool(now["error_mm"] >= CAP_MM)
            worse.append(EpisodeDifference(name, seed, grown, new_events, replay, capped))
    worse.sort(key=lambda e: (-len(e.events), -e.error_mm, e.scenario, e.seed))
    return tuple(worse[:MOST_WORST])
