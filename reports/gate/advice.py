"""Why a verdict is inconclusive, and the commands that would decide it."""

from __future__ import annotations

import math
import shlex
from collections.abc import Mapping, Sequence
from typing import Any

from scipy.special import ndtr, ndtri, stdtrit

from reports.gate.metrics import METRICS
from reports.gate.replay import system_options, targets_of
from reports.gate.statistics import Difference
from reports.gate.text import interval_text, number, unit_text
from reports.gate.verdict import Advice, MetricVerdict
from reports.run.load import SavedRun
from reports.summary.text import count

POWER = 0.8  # probability of a clear verdict that is asked for
MOST_SEEDS = 1000  # of a scenario; whoever needs more has a margin that is too narrow
GROWTH = 1.1  # of the seeds that are tried


def advice_of(
    base: SavedRun, new: SavedRun, judged: Sequence[MetricVerdict], alpha: float
) -> Advice | None:
    """The advice for a comparison, None where no metric is inconclusive.

    alpha: the share of false alarms allowed. More seeds are taken to have the measured mean and
    spread.
    """
    open_ = [m for m in judged if m.verdict == "inconclusive"]
    if not open_:
        return None
    tests = sum(not metric.counted for metric in METRICS)
    least = least_draws(alpha, tests)
    whole = open_[0].difference
    seeds = max(len(scenario["seeds"]) for scenario in new.meta["scenarios"])
    per_seed = whole.draws / seeds
    reason = _reason(open_, whole, least)
    if not all(math.isfinite(m.difference.low) for m in open_):
        wanted = math.ceil(least / per_seed)
        return Advice(reason, wanted, None, _commands(base, new, judged, wanted))
    wanted, power = _seeds_that_decide(open_, seeds, per_seed, alpha, tests)
    if power < POWER:
        reason += f"; up to {MOST_SEEDS} seeds would not tell: the difference is about the margin"
        return Advice(reason, None, None, ())
    return Advice(reason, wanted, power, _commands(base, new, judged, wanted))


def least_draws(alpha: float, tests: int) -> int:
    """The fewest draws of which an exact test can reject after Holm's correction."""
    return math.floor(math.log2(tests / alpha)) + 1


def power_of(d: Difference, margin: float, draws: float, alpha: float, tests: int) -> float:
    """The probability that a number of draws gives a pass or a fail.

    Mean and spread are taken as measured, the distribution as normal; tests: over how many Holm
    corrects.
    """
    se = (d.high - d.low) / 2 / -stdtrit(d.draws - 1, alpha / 2) * math.sqrt(d.draws / draws)
    if se == 0.0:
        return 1.0
    half = -stdtrit(draws - 1, alpha / 2) * se
    passes = ndtr((margin - half - d.mean) / se)
    enough = draws >= least_draws(alpha, tests)
    needed = max(margin, half, -ndtri(alpha / tests) * se)
    return float(passes + (ndtr((d.mean - needed) / se) if enough else 0.0))


def _seeds_that_decide(
    open_: Sequence[MetricVerdict], seeds: int, per_seed: float, alpha: float, tests: int
) -> tuple[int, float]:
    """The fewest seeds with which each metric is decided with `POWER`, and that probability."""
    wanted, power = seeds, 0.0
    while power < POWER and wanted < MOST_SEEDS:
        wanted = min(max(wanted + 1, round(wanted * GROWTH)), MOST_SEEDS)
        draws = wanted * per_seed
        power = min(power_of(m.difference, m.metric.margin, draws, alpha, tests) for m in open_)
    return wanted, power


def _reason(open_: Sequence[MetricVerdict], whole: Difference, least: int) -> str:
    size = f"{count(whole.n, 'episode')} of {count(whole.draws, 'draw')}"
    if whole.draws < least:
        return f"{size}: under {least} draws only `failed` can fail"
    clauses = []
    for m in open_:
        unit = unit_text(m.metric)
        clauses.append(
            f"{m.metric.name} may be {interval_text(m)}{unit}, its margin is "
            f"{number(m.metric.margin)}{unit}"
        )
    return f"{size}: {'; '.join(clauses)}"


def _commands(
    base: SavedRun, new: SavedRun, judged: Sequence[MetricVerdict], seeds: int
) -> tuple[str, ...]:
    """Commands that play both runs with more seeds and compare them; none for other runs' files."""
    folders = [f"runs/{role}-{seeds}-seeds" for role in ("base", "new")]
    played = [
        _played_again(run.meta, seeds, out) for run, out in zip((base, new), folders, strict=True)
    ]
    if not all(played):
        return ()
    usual = {metric.name: metric.margin for metric in METRICS}
    margins = [
        word
        for m in judged
        if m.metric.margin != usual[m.metric.name]
        for word in ("--margin", f"{m.metric.name}={m.metric.margin:g}")
    ]
    return (*played, shlex.join(["pjpdaf-bench", "compare", *folders, *margins]))


def _played_again(meta: Mapping[str, Any], seeds: int, out: str) -> str:
    """The command that plays a run with more seeds; "" of a data set or of somebody's tracks."""
    request = meta.get("request")
    if not request or request.get("dataset"):
        return ""
    words = ["pjpdaf-bench", "run", *targets_of(meta)]
    for name in request["only"]:
        words += ["--only", name]
    words += ["--first-seed", str(request["first_seed"])] if request["first_seed"] else []
    words += ["--seeds", str(seeds), *system_options(meta), "--out", out]
    return shlex.join(words)


def advice_lines(advice: Advice) -> tuple[str, ...]:
    """The advice in words, without its commands."""
    if advice.seeds is None:
        return (f"why: {advice.reason}",)
    chance = ""
    if advice.power is not None:
        chance = f", a clear verdict of each metric in {100 * advice.power:.0f} % of all cases"
    remedy = f"--seeds {advice.seeds} of both"
    if not advice.commands:
        remedy = f"play both on a set of `dataset make --seeds {advice.seeds}`, or more scenarios"
    return f"why: {advice.reason}", f"to decide: {remedy}{chance}"
