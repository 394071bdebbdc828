import json
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
import pytest

from pjpdaf.errors import BenchError
from reports.formats import badge_json, junit_xml, markdown, verdict_json
from reports.gate import METRICS, NotComparable, compare, episode_values
from reports.records import EpisodeFailure
from reports.results import RunInfo, load, save

GROUPS = {"calm": "baseline", "drink": "hand_and_head", "cross": "hand_and_hand"}


def episodes(episode_of, tools, worse=lambda scenario, seed: 0.0, swapped=(), seeds=8):
    """Runs of three scenarios; `worse` shifts all estimates by that much [m]."""
    for scenario, group in GROUPS.items():
        for seed in range(seeds):
            paths = tools.paths(24, 3.0, 0.1 + 0.01 * seed)
            said = tools.noisy(paths, seed) + np.array([0.0, 0.0, worse(scenario, seed)])
            if (scenario, seed) in swapped:
                said[8:, [1, 2]] = said[8:, [2, 1]]
            yield episode_of(said, scenario=scenario, group=group, seed=seed, centres_m=paths)


@pytest.fixture(scope="module")
def runs(episode_of, tools, tmp_path_factory):
    folder = tmp_path_factory.mktemp("runs")

    def run_of(name, extra=(), drop=0, **changes):
        played = list(episodes(episode_of, tools, **changes))
        played = [*played[drop:], *extra]
        return load(save(folder / name, played, RunInfo(name)))

    return {
        "base": run_of("base"),
        "again": run_of("again"),
        "worse": run_of("worse", worse=lambda s, k: 0.012),
        "better": run_of("better", worse=lambda s, k: 0.0),
        "jitter": run_of("jitter", worse=lambda s, k: 0.0004 * (-1) ** k),
        "half": run_of("half", worse=lambda s, k: 0.03 if s == "drink" else 0.0),
        "swaps": run_of("swaps", swapped={("cross", k) for k in range(8)}),
        "one_swap": run_of("one_swap", swapped={("cross", 3)}),
        "fewer": run_of("fewer", drop=1),
    }


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
    with pytest.raises(BenchError, match="no metric 'eror_mm'; known: error_mm, missed"):
        compare(runs["base"], runs["worse"], {"eror_mm": 1.0})
    with pytest.raises(BenchError, match="0 or more, got nan"):
        compare(runs["base"], runs["worse"], {"lost": float("nan")})


def test_unlike_runs_are_not_compared(runs, episode_of, tools, tmp_path):
    with pytest.raises(NotComparable, match=r"lacks 1 of 24 .*calm seed 0"):
        compare(runs["base"], runs["fewer"])
    with pytest.raises(NotComparable, match="lacks 1 of 24"):
        compare(runs["fewer"], runs["base"])
    assert NotComparable("x").exit_code == 4
    other = []
    for episode in episodes(episode_of, tools):
        object.__setattr__(episode, "digest", episode.digest + "x")
        other.append(episode)
    changed = load(save(tmp_path / "changed", other, RunInfo("changed")))
    with pytest.raises(NotComparable, match="24 of 24 episodes are not the same"):
        compare(runs["base"], changed)
    cut = load(save(tmp_path / "cut", episodes(episode_of, tools), RunInfo("c", complete=False)))
    with pytest.raises(NotComparable, match="was interrupted"):
        compare(runs["base"], cut)


def test_an_episode_without_a_result_counts_as_the_worst(episode_of, tools, tmp_path):
    whole = list(episodes(episode_of, tools))
    base = load(save(tmp_path / "base", whole, RunInfo("base")))
    crashed = EpisodeFailure("cross", 7, "worker died", "hand_and_hand", whole[-1].digest)
    new = load(save(tmp_path / "new", [*whole[:-1], crashed], RunInfo("new")))
    values = episode_values(new).loc[("cross", 7)]
    assert values["error_mm"] == 500.0
    assert values["missed"] == 1.0
    assert values["failed"]
    verdict = compare(base, new)
    assert of(verdict, "failed").verdict != "pass"
    assert verdict.worst[0].scenario == "cross"
    assert "failed" in verdict.worst[0].events


def test_no_false_alarm_when_the_two_runs_only_differ_by_chance(runs):
    """Base and new drawn from the same two runs by a coin per episode: 1000 no-op comparisons."""
    from reports.gate import ALPHA, _word
    from reports.statistics import holm, mcnemar, paired_bootstrap

    one, other = episode_values(runs["base"]), episode_values(runs["half"])
    alarms = 0
    for seed in range(1000):
        rng = np.random.default_rng(seed)
        coin = rng.random(len(one)) < 0.5
        found = []
        for metric in METRICS:
            a = one[metric.name].to_numpy(dtype=float)
            b = other[metric.name].to_numpy(dtype=float)
            base, new = np.where(coin, a, b), np.where(coin, b, a)
            difference = paired_bootstrap(new - base, one["group"].tolist(), rng, resamples=499)
            p = mcnemar(base > 0, new > 0) if metric.event else difference.p_worse
            found.append((metric, difference, p))
        adjusted = holm([p for _, _, p in found])
        words = [_word(m, d, p) for (m, d, _), p in zip(found, adjusted, strict=True)]
        alarms += "fail" in words
    assert alarms <= 1000 * ALPHA


def test_the_files_say_the_same(runs):
    verdict = compare(runs["base"], runs["half"])
    record = json.loads(verdict_json(verdict, ("compare", "a", "b")))
    assert record["verdict"] == "fail"
    assert record["provenance"]["argv"] == ["compare", "a", "b"]
    assert {m["metric"]["name"] for m in record["metrics"]} == {m.name for m in METRICS}
    root = ElementTree.fromstring(junit_xml(verdict))
    assert root.tag == "testsuites"
    suites = root.findall("testsuite")
    assert {s.get("name") for s in suites} == set(GROUPS.values())
    for suite in suites:
        cases = suite.findall("testcase")
        assert int(suite.get("tests")) == len(cases) == len(METRICS)
        assert int(suite.get("failures")) == len(suite.findall("testcase/failure"))
        assert int(suite.get("skipped")) == len(suite.findall("testcase/skipped"))
    assert int(root.get("failures")) == sum(g.verdict == "fail" for g in verdict.groups) > 0
    text = markdown(verdict)
    assert "❌ fail" in text
    assert "run drink --seeds" in text
    assert json.loads(badge_json(verdict)) == {
        "schemaVersion": 1, "label": "tracking accuracy", "message": "fail", "color": "red",
    }  # fmt: skip
    assert json.loads(badge_json(compare(runs["base"], runs["again"])))["message"] == "identical"


def test_names_cannot_break_the_table_or_the_xml(episode_of, tools, tmp_path):
    name = "a|b`c\x07<&>"
    made = []
    for k, shift in enumerate((0.0, 0.2)):
        paths = tools.paths(20, 3.0)
        played = [
            episode_of(paths + shift, scenario=name, group=name, seed=s, centres_m=paths)
            for s in range(3)
        ]
        made.append(load(save(Path(tmp_path) / str(k), played, RunInfo(name))))
    verdict = compare(*made)
    ElementTree.fromstring(junit_xml(verdict))
    rows = [line for line in markdown(verdict).splitlines() if line.startswith("| ")]
    assert {line.count("|") for line in rows if "mm |" in line and "run" in line} <= {6}
