"""The gate: what fails, what passes, what stays open."""

from dataclasses import replace

import numpy as np
import pytest

from pjpdaf.errors import BenchError, InfrastructureError
from reports.gate.gate import ALPHA, compare
from reports.gate.metrics import METRICS
from reports.gate.pairing import (
    CAP_MM,
    WORST_GOSPA_MM,
    episode_values,
)
from reports.run.load import load
from reports.run.save import RunInfo, save
from reports.score.records import EpisodeFailure


def of(verdict, name):
    return next(m for m in verdict.metrics if m.metric.name == name)


def test_the_same_results_pass_at_once_as_identical(runs):
    verdict = compare(runs["base"], runs["again"])
    assert verdict.verdict == "pass"
    assert verdict.identical
    assert all(m.difference.mean == 0 for m in verdict.metrics)


def test_small_changes_in_both_directions_pass(runs):
    verdict = compare(runs["base"], runs["jitter"])
    assert verdict.verdict == "pass"
    assert not verdict.identical


def test_a_clear_loss_of_accuracy_fails_the_metrics_that_show_it(runs):
    verdict = compare(runs["base"], runs["worse"])
    assert verdict.verdict == "fail"
    assert of(verdict, "error_mm").verdict == "fail"
    assert of(verdict, "swapped").verdict == "pass"
    shown = of(verdict, "error_mm").difference
    assert shown.low <= shown.mean <= shown.high


def test_the_other_way_round_it_is_an_improvement_and_passes(runs):
    assert compare(runs["worse"], runs["base"]).verdict == "pass"


def test_a_loss_in_one_group_names_that_group(runs):
    verdict = compare(runs["base"], runs["half"])
    failed = {g.group for g in verdict.groups if g.verdict == "fail"}
    assert of(verdict, "error_mm").verdict == "fail"
    assert failed == {"hand_and_head"}
    assert {e.scenario for e in verdict.worst} == {"drink"}


def test_swaps_fail_by_mcnemar_one_swap_is_inconclusive(runs):
    many, one = compare(runs["base"], runs["swaps"]), compare(runs["base"], runs["one_swap"])
    assert of(many, "swapped").verdict == "fail"
    assert of(one, "swapped").verdict == "inconclusive"
    assert one.worst[0].events[0] == "swapped"


def test_wide_margins_forgive_and_unknown_ones_are_named(runs):
    assert (
        of(compare(runs["base"], runs["worse"], {"error_mm": 50.0}), "error_mm").verdict == "pass"
    )
    with pytest.raises(BenchError, match=r"No metric 'eror_mm'\. Did you mean 'error_mm'"):
        compare(runs["base"], runs["worse"], {"eror_mm": 1.0})
    with pytest.raises(BenchError, match="0 or more, got nan"):
        compare(runs["base"], runs["worse"], {"lost": float("nan")})


def with_meta(run, **changes):
    return replace(run, meta={**run.meta, **changes})


def with_scenarios(run, **changes):
    return with_meta(run, scenarios=[{**one, **changes} for one in run.meta["scenarios"]])


def with_failures(run, failed, reason, kind="exception"):
    """A run in which these episodes gave no result."""
    rows = run.episodes.copy()
    hit = [key in failed for key in zip(rows["scenario"], rows["seed"], strict=True)]
    for column in ("frames", "within_100", "median_error_mm", "median_err_acc_px"):
        rows.loc[hit, column] = 0
    rows.loc[hit, ["ever_swapped", "ever_lost"]] = False
    rows.loc[hit, "failure"] = reason
    tracking = run.tracking
    gone = [key in failed for key in zip(tracking["scenario"], tracking["seed"], strict=True)]
    scenarios = [
        {
            **scenario,
            "failures": [
                {"seed": seed, "reason": reason, "kind": kind}
                for seed in scenario["seeds"]
                if (scenario["name"], seed) in failed
            ],
        }
        for scenario in run.meta["scenarios"]
    ]
    meta = {**run.meta, "scenarios": scenarios}
    return replace(run, meta=meta, episodes=rows, tracking=tracking[~np.array(gone)])


def test_a_failed_episode_is_saved_and_counts_as_the_worst(episodes, tmp_path):
    whole = list(episodes())
    base = load(save(tmp_path / "base", whole, RunInfo("base")))
    crashed = EpisodeFailure("cross", 7, "worker died", "hand_and_hand", whole[-1].digest)
    new = load(save(tmp_path / "new", [*whole[:-1], crashed], RunInfo("new")))
    values = episode_values(new).loc[("cross", 7)]
    assert values["error_mm"] == CAP_MM
    assert values["missed"] == 1.0
    assert values["gospa_mm"] == WORST_GOSPA_MM
    assert values["failed"]
    verdict = compare(base, new)
    assert of(verdict, "failed").verdict == verdict.verdict == "fail"
    assert verdict.worst[0].scenario == "cross"
    assert "failed" in verdict.worst[0].events


def test_one_crash_fails_and_a_cured_one_does_not_make_up_for_it(runs):
    crashed = with_failures(runs["base"], {("cross", 7)}, "KeyError: 1")
    other = with_failures(runs["base"], {("calm", 0)}, "KeyError: 1")
    assert of(compare(runs["base"], crashed), "failed").verdict == "fail"
    assert of(compare(other, crashed), "failed").verdict == "fail"
    assert compare(crashed, runs["base"]).verdict == "pass"
    allowed = compare(runs["base"], crashed, {"failed": 0.05})
    assert of(allowed, "failed").verdict == "pass"


def test_what_the_base_has_no_result_of_cannot_hide_a_loss(runs):
    """A crash that is cured is 150 mm better; that must not pay for 12 mm in all the others."""
    base = with_failures(runs["base"], {("calm", 0)}, "KeyError: 1")
    verdict = compare(base, runs["worse"])
    assert verdict.left_out == 1
    assert of(verdict, "error_mm").verdict == "fail"
    assert of(verdict, "error_mm").difference.n == 23


def test_a_base_without_results_is_no_yardstick(runs, groups):
    every = {(s, k) for s in groups for k in range(8)}
    some = {("calm", k) for k in range(4)}
    with pytest.raises(InfrastructureError, match=r"4 of 24 episodes .* calm seed 0: worker died"):
        compare(with_failures(runs["base"], some, "worker died"), runs["again"])
    unposable = with_failures(runs["base"], some, "cannot be posed: too far", "unposable")
    assert compare(unposable, unposable).verdict == "pass"
    with pytest.raises(InfrastructureError, match="24 of 24"):
        compare(with_failures(runs["base"], every, "cannot be posed: too far"), runs["again"])


def test_an_accident_counts_but_does_not_hide_what_happens_in_all_others(runs):
    """All targets of an episode 100 mm off by luck in the base; that one counts 30 mm."""
    odd = runs["base"].episodes.copy()
    odd.loc[:2, "median_error_mm"] += 100.0
    lucky = compare(replace(runs["base"], episodes=odd), runs["worse"])
    plain = compare(runs["base"], runs["worse"])
    one, other = (of(verdict, "error_mm") for verdict in (lucky, plain))
    values = [episode_values(runs[name])["error_mm"].iloc[0] for name in ("base", "worse")]
    lost = (values[1] - values[0] + 30.0) / 24
    assert one.difference.mean == pytest.approx(other.difference.mean - lost)
    assert one.metric.reach == 30.0 == 10 * one.metric.margin
    wide = of(compare(runs["base"], runs["worse"], {"error_mm": 50.0}), "error_mm")
    assert wide.metric.reach == 500.0


def test_a_better_metric_passes_and_says_so(runs):
    verdict = compare(runs["worse"], runs["base"])
    assert of(verdict, "error_mm").better
    assert not of(verdict, "swapped").better
    assert compare(runs["swaps"], runs["base"]).verdict == "pass"


def test_one_episode_decides_nothing(runs):
    def one(run):
        tables = {
            name: getattr(run, name)[
                (getattr(run, name)["scenario"] == "calm") & (getattr(run, name)["seed"] == 0)
            ]
            for name in ("episodes", "events", "tracking", "frames")
        }
        scenario = next(s for s in run.meta["scenarios"] if s["name"] == "calm")
        short = {**scenario, "seeds": [0], "digests": scenario["digests"][:1]}
        short = {key: value for key, value in short.items() if key != "truths"}
        return replace(with_meta(run, scenarios=[short]), **tables)

    verdict = compare(one(runs["base"]), one(runs["worse"]))
    assert verdict.verdict == "inconclusive"
    assert of(verdict, "error_mm").difference.high == np.inf
    assert of(verdict, "swapped").verdict == "pass"
    assert compare(one(runs["base"]), one(runs["again"])).identical


def test_episodes_of_one_draw_are_no_independent_evidence(runs):
    """Eight seeds of three scenarios; where these share their draws, there are eight draws."""
    alone = compare(runs["base"], runs["swaps"])
    base, new = (with_scenarios(runs[name], family="f") for name in ("base", "swaps"))
    shared = compare(base, new)
    assert of(alone, "error_mm").difference.draws == 24
    assert of(shared, "error_mm").difference.draws == 8


def test_more_looks_need_more_evidence(runs):
    once = compare(runs["base"], runs["worse"])
    often = compare(runs["base"], runs["worse"], looks=4)
    assert (once.alpha, often.alpha) == (ALPHA, ALPHA / 4)
    one, four = (of(v, "error_mm").difference for v in (once, often))
    assert four.high - four.low > one.high - one.low


def test_a_group_that_got_worse_shows_also_where_the_whole_passes(runs):
    verdict = compare(runs["base"], runs["half"], {"error_mm": 12.0})
    beyond = {(g.group, g.metric.name) for g in verdict.groups if g.beyond}
    assert of(verdict, "error_mm").verdict != "fail"
    assert ("hand_and_head", "error_mm") in beyond
    assert ("baseline", "error_mm") not in beyond


@pytest.mark.long
def test_no_false_alarm_when_the_two_runs_only_differ_by_chance(runs):
    """Base and new drawn from the same two runs by a coin per episode: no-op comparisons."""
    values = {name: episode_values(runs[name]) for name in ("base", "half", "swaps")}
    alarms, tries = 0, 150
    for seed in range(tries):
        one, other = values["base"], values[("half", "swaps")[seed % 2]]
        coin = np.random.default_rng(seed).random((len(one), 1)) < 0.5
        coin = np.broadcast_to(coin, one.shape)
        words = verdicts(one.where(coin, other), other.where(coin, one), seed)
        alarms += "fail" in words
    assert alarms <= tries * ALPHA


def verdicts(before, after, seed):
    """What `compare` makes of two tables of episode values."""
    from reports.gate.gate import _difference, _outcome
    from reports.gate.statistics import holm
    from reports.gate.verdict import MetricVerdict

    rng = np.random.default_rng(seed)
    found = [(m, *_difference(m, before, after, rng, ALPHA)) for m in METRICS if not m.counted]
    adjusted = holm([p for _, _, p in found])
    return [
        _outcome(MetricVerdict(metric, "pass", 0.0, 0.0, difference, p), ALPHA)
        for (metric, difference, _), p in zip(found, adjusted, strict=True)
    ]
