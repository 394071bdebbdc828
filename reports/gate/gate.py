"""The gate: is a new run worse than its base? A verdict per metric, paired episode by episode."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
import pandas as pd

from pjpdaf.arrays import Floats
from pjpdaf.errors import BenchError, InfrastructureError
from reports.gate.pairing import check_comparable, episode_values, notes_of, same_results
from reports.gate.statistics import Difference, clustered_bootstrap, holm, mcnemar, sign_flip
from reports.run.failures import failures_of
from reports.run.load import SavedRun
from reports.score.gospa import CUT_OFF_M

ALPHA = 0.05
REACH = 10.0  # margins; see Metric.reach
BUDGET = 0.05  # share of episodes that the base may lack results of
MOST_WORST = 10

Word = Literal["pass", "fail", "inconclusive"]


@dataclass(frozen=True)
class Metric:
    """What an episode is measured by; more is always worse.

    margin: the greatest difference of the means that does not matter, in `unit`. event: it happened
    or it did not. counted: judged by the count alone: what happened is no sample of anything.
    reach: a greater difference in one episode counts as this. Such an episode was lost or swapped,
    which is counted as that; else a few of them would hide what happens in all others.
    """

    name: str
    unit: str
    margin: float
    meaning: str
    event: bool = False
    counted: bool = False
    reach: float = float("inf")


METRICS = (
    Metric(
        "error_mm", "mm", 3.0, "median 3-D error of a target, mean over the targets", reach=30.0
    ),
    Metric("missed", "1", 0.02, "share of target-frames not within 100 mm", reach=0.2),
    Metric(
        "err_acc_px",
        "px",
        0.5,
        "median distance in the picture (Eq. 4.1), mean over targets",
        reach=5.0,
    ),
    Metric(
        "gospa_mm",
        "mm",
        4.0,
        f"mean GOSPA of a frame, cut-off {CUT_OFF_M * 1000:.0f} mm",
        reach=40.0,
    ),
    Metric("swapped", "1", 0.02, "episodes in which the hands were swapped", event=True),
    Metric("lost", "1", 0.02, "episodes in which a target was lost", event=True),
    Metric(
        "failed", "1", 0.0, "episodes that gave a result in the base only", event=True, counted=True
    ),
)


@dataclass(frozen=True)
class MetricVerdict:
    """The verdict of one metric.

    base, new: median of the episodes, of shares the mean; difference: of the pairs, so not the one
    of these two; p: one-sided, adjusted after Holm (1 where nothing is estimated).
    """

    metric: Metric
    verdict: Word
    base: float
    new: float
    difference: Difference
    p: float

    @property
    def better(self) -> bool:
        """Whether the new run is better beyond doubt."""
        return self.difference.high < 0


@dataclass(frozen=True)
class GroupDifference:
    """How one group of scenarios differs in one metric.

    base, new, difference: as in `MetricVerdict`. verdict: the metric's, where this group is beyond
    the margin, else "pass".
    """

    group: str
    metric: Metric
    verdict: Word
    base: float
    new: float
    difference: float
    episodes: int

    @property
    def beyond(self) -> bool:
        """Whether this group alone is worse by more than the margin; that decides nothing."""
        return self.difference > self.metric.margin


@dataclass(frozen=True)
class EpisodeDifference:
    """One episode whose error grew: by how much, and what happened in it that did not before.

    replay: the command that plays it again, "" where the run does not know how it was started.
    """

    scenario: str
    seed: int
    error_mm: float
    events: tuple[str, ...]
    replay: str


@dataclass(frozen=True)
class Verdict:
    """The outcome of a comparison.

    identical: all that was measured is the same. episodes: pairs; left_out: of these, without a
    result in the base, and so only in the metric "failed". looks: how many times the data may be
    looked at; alpha: the share of false alarms allowed this time. notes: what else differs between
    the runs.
    """

    base: str
    new: str
    verdict: Word
    identical: bool
    episodes: int
    left_out: int
    looks: int
    alpha: float
    metrics: tuple[MetricVerdict, ...]
    groups: tuple[GroupDifference, ...]
    worst: tuple[EpisodeDifference, ...]
    notes: tuple[str, ...]


def compare(
    base: SavedRun,
    new: SavedRun,
    margins: Mapping[str, float] | None = None,
    seed: int = 0,
    looks: int = 1,
) -> Verdict:
    """The verdict on `new`.

    A metric fails where its mean difference is more than the margin and significantly above 0: the
    interval (clustered bootstrap) and, after Holm over the metrics, an exact test (episodes: sign
    flips; events: McNemar). It passes where the interval's upper end is within the margin; else it
    is inconclusive. One failure fails all. looks: where the same data are judged again with more
    episodes, how often at most; each look then has its share of 5 % (Bonferroni).

    Raises NotComparable, BenchError for a margin of no metric, InfrastructureError where the base
    lacks too many results to be a yardstick.
    """
    check_comparable(base, new)
    metrics = with_margins(margins or {})
    before, after = episode_values(base), episode_values(new)
    known = ~before["failed"].to_numpy(dtype=bool)
    _check_yardstick(base, known)
    alpha = ALPHA / looks
    rng = np.random.default_rng(seed)
    judged: list[MetricVerdict] = []
    p_values: list[float] = []
    for metric in metrics:
        rows = np.ones(len(known), dtype=bool) if metric.counted else known
        old, now = before[rows], after[rows]
        difference, p = _difference(metric, old, now, rng, alpha)
        was, is_now = _typical(metric, old), _typical(metric, now)
        judged.append(MetricVerdict(metric, "pass", was, is_now, difference, p))
        p_values += [] if metric.counted else [p]
    adjusted = iter(holm(p_values))
    judged = [one if one.metric.counted else replace(one, p=next(adjusted)) for one in judged]
    judged = [replace(one, verdict=_word(one, alpha)) for one in judged]
    return Verdict(
        base=base.name,
        new=new.name,
        verdict=worst_of([m.verdict for m in judged]),
        identical=same_results(base, new),
        episodes=len(before),
        left_out=int((~known).sum()),
        looks=looks,
        alpha=alpha,
        metrics=tuple(judged),
        groups=_groups(judged, before, after, known),
        worst=_worst(before, after, new.meta),
        notes=notes_of(base, new),
    )


def _typical(metric: Metric, values: pd.DataFrame) -> float:
    """Median of the episodes; of shares, whose median says little, the mean."""
    column = values[metric.name].to_numpy(dtype=np.float64)
    return float(column.mean() if metric.unit == "1" else np.median(column))


def _changes(metric: Metric, before: pd.DataFrame, after: pd.DataFrame) -> Floats:
    """Per episode, new - base, within reach."""
    old, now = (v[metric.name].to_numpy(dtype=np.float64) for v in (before, after))
    # A failure that is cured does not make up for one that is new.
    least = 0.0 if metric.counted else -metric.reach
    return np.asarray(np.clip(now - old, least, metric.reach))


def _check_yardstick(base: SavedRun, known: np.ndarray) -> None:
    absent = int((~known).sum())
    # Seeds that cannot be posed fail in both; they are no fault of the machine.
    rows = base.episodes[base.episodes["failure"] != ""]
    broken = [failure for failure in failures_of(base) if failure.kind != "unposable"]
    if absent == len(known) or len(broken) > BUDGET * len(known):
        first = rows.iloc[0]
        raise InfrastructureError(
            f"{base.folder}: {absent} of {len(known)} episodes have no result, the first: "
            f"{first['scenario']} seed {first['seed']}: {first['failure']}; play the base again"
        )


def with_margins(margins: Mapping[str, float]) -> tuple[Metric, ...]:
    """The metrics with these margins instead of their own. Raises BenchError for an unknown one."""
    known = {metric.name: metric for metric in METRICS}
    for name, margin in margins.items():
        if name not in known:
            raise BenchError(f"no metric {name!r}; known: {', '.join(known)}")
        if not (np.isfinite(margin) and margin >= 0):
            raise BenchError(f"margin of {name} must be a number of 0 or more, got {margin}")
    found = []
    for metric in METRICS:
        margin = float(margins.get(metric.name, metric.margin))
        found.append(replace(metric, margin=margin, reach=max(metric.reach, REACH * margin)))
    return tuple(found)


def worst_of(words: Sequence[Word]) -> Word:
    """fail before inconclusive before pass."""
    for word in ("fail", "inconclusive"):
        if word in words:
            return word
    return "pass"


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
    return difference, mcnemar(changes, draws) if metric.event else sign_flip(changes, draws, rng)


def _word(judged: MetricVerdict, alpha: float) -> Word:
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
        for one in judged:
            rows = (groups == group) & (known | one.metric.counted)
            if not rows.any():
                continue
            old, now = before[rows], after[rows]
            found = GroupDifference(
                group=group,
                metric=one.metric,
                verdict="pass",
                base=_typical(one.metric, old),
                new=_typical(one.metric, now),
                difference=float(_changes(one.metric, old, now).mean()),
                episodes=int(rows.sum()),
            )
            out.append(replace(found, verdict=one.verdict if found.beyond else "pass"))
    return tuple(out)


def _worst(
    before: pd.DataFrame, after: pd.DataFrame, meta: Mapping[str, Any]
) -> tuple[EpisodeDifference, ...]:
    """The episodes that got worse, the worst first: new events before grown errors."""
    events = [metric.name for metric in METRICS if metric.event]
    found = []
    for key, old, now in zip(
        before.index, before.to_dict("records"), after.to_dict("records"), strict=True
    ):
        name, seed = str(key[0]), int(key[1])
        new_events = tuple(event for event in events if now[event] and not old[event])
        grown = float(now["error_mm"] - old["error_mm"])
        if new_events or grown > 0:
            replay = replay_command(meta, name, seed)
            found.append(EpisodeDifference(name, seed, grown, new_events, replay))
    found.sort(key=lambda e: (-len(e.events), -e.error_mm, e.scenario, e.seed))
    return tuple(found[:MOST_WORST])


def replay_command(meta: Mapping[str, Any], name: str, seed: int) -> str:
    """The command that plays one episode of a run again, name being its name in the results.

    "" where run.json does not say what was asked for.
    """
    request = meta.get("request")
    if not request:
        return ""
    words = ["pjpdaf-bench", "run", *request["targets"]]
    words += ["--only", name, "--first-seed", str(seed), "--seeds", "1"]
    words += words_of_system(meta)
    return shlex.join(words)


def words_of_system(meta: Mapping[str, Any]) -> list[str]:
    """The options of `run` that say what was under test, as run.json has it."""
    words: list[str] = []
    preset = str(meta["preset"])
    words += ["--preset", preset] if preset != "thesis" else []
    for part in ("detector", "tracker"):
        words += [f"--{part}", str(meta[part])] if meta[part] != preset else []
    for pair in meta["request"]["settings"]:
        words += ["--set", str(pair)]
    return words
