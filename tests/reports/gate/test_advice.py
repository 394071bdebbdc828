"""The reason why a comparison is inconclusive, and how many seeds would decide it."""

import shlex
from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import t

from reports.gate.advice import POWER, advice_lines, least_draws, power_of
from reports.gate.gate import ALPHA, compare
from reports.gate.metrics import METRICS
from reports.gate.statistics import Difference
from reports.run.load import load
from reports.run.save import RunInfo, save

TESTS = 6
REQUEST = {"targets": ["my suite"], "seeds": 2, "first_seed": 0, "only": [], "settings": ["fps=3"]}


@pytest.fixture(scope="module")
def few(episodes, tmp_path_factory):
    """Two seeds of three scenarios: six draws."""
    folder = tmp_path_factory.mktemp("few")

    def run_of(name, worse):
        info = RunInfo(
            name, preset="thesis", detector="thesis", tracker="mine:make", request=REQUEST
        )
        return load(save(folder / name, list(episodes(seeds=2, worse=worse)), info))

    return {
        "base": run_of("base", lambda s, k: 0.0),
        "worse": run_of("worse", lambda s, k: 0.02),
        "mixed": run_of("mixed", lambda s, k: 0.02 * (s == "drink")),
    }


def test_the_fewest_draws_that_can_fail_are_seven():
    assert least_draws(ALPHA, TESTS) == 7
    assert TESTS / 2**7 < ALPHA < TESTS / 2**6


@pytest.mark.parametrize(
    ("mean", "margin", "draws"), [(1.0, 3.0, 20), (4.0, 3.0, 30), (2.9, 3.0, 40)]
)
def test_the_power_is_that_of_simulated_comparisons(mean, margin, draws):
    rng, sd, n = np.random.default_rng(0), 4.0, 12
    half = t.isf(ALPHA / 2, n - 1) * sd / np.sqrt(n)
    measured = Difference(mean, mean - half, mean + half, n, n)
    drawn = rng.normal(mean, sd, (4000, draws))
    means = drawn.mean(axis=1)
    halves = t.isf(ALPHA / 2, draws - 1) * drawn.std(axis=1, ddof=1) / np.sqrt(draws)
    zs = means / (drawn.std(axis=1, ddof=1) / np.sqrt(draws))
    passes = means + halves <= margin
    fails = (means > margin) & (means > halves) & (zs > 2.394)  # isf(0.05 / 6)
    wanted = float(np.mean(passes | fails))
    assert power_of(measured, margin, draws, ALPHA, TESTS) == pytest.approx(wanted, abs=0.05)


def test_few_draws_are_named_as_the_reason_and_more_seeds_as_the_remedy(few):
    verdict = compare(few["base"], few["worse"], {"error_mm": 2.5})
    advice = verdict.advice
    assert verdict.verdict == "inconclusive"
    assert advice.reason == "6 episodes of 6 draws: under 7 draws only `failed` can fail"
    assert advice.seeds > 2
    assert advice.power >= POWER
    base, new, last = map(shlex.split, advice.commands)
    assert base == [
        *("pjpdaf-bench", "run", "my suite", "--seeds", str(advice.seeds), "--preset", "thesis"),
        *("--tracker", "mine:make", "--set", "fps=3"),
        *("--out", f"runs/base-{advice.seeds}-seeds"),
    ]
    assert last[:4] == ["pjpdaf-bench", "compare", base[-1], new[-1]]
    assert last[4:] == ["--margin", "error_mm=2.5"]
    why, remedy = advice_lines(advice)
    assert why == f"why: {advice.reason}"
    assert remedy.startswith(
        f"to decide: --seeds {advice.seeds} of both, a clear verdict of each metric in "
    )


def test_an_interval_that_is_too_wide_is_named_with_its_margin(runs):
    verdict = compare(runs["base"], runs["one_swap"])
    assert verdict.verdict == "inconclusive"
    assert "24 episodes of 24 draws: " in verdict.advice.reason
    assert "swapped may be " in verdict.advice.reason
    assert ", its margin is 0.02" in verdict.advice.reason
    assert verdict.advice.commands == ()  # these runs do not say how they were started
    assert (
        "to decide: play both on a set of `dataset make --seeds " in advice_lines(verdict.advice)[1]
    )


def test_a_difference_at_the_margin_is_not_promised_a_verdict(few):
    verdict = compare(few["base"], few["mixed"])
    error = next(m for m in verdict.metrics if m.metric.name == "error_mm")
    at_it = compare(few["base"], few["mixed"], {"error_mm": error.difference.mean})
    assert at_it.advice.seeds is None
    assert "up to 1000 seeds would not tell" in at_it.advice.reason


def test_a_clear_verdict_needs_no_advice(runs):
    assert compare(runs["base"], runs["worse"]).advice is None


def test_shares_stay_within_one_and_capped_differences_are_counted(few):
    whole = compare(few["base"], few["worse"])
    for judged in whole.metrics:
        if judged.metric.unit == "1":
            assert -1.0 <= judged.difference.low <= judged.difference.high <= 1.0
    narrow = replace(METRICS[0], reach=1.0)
    from reports.gate.gate import _capped
    from reports.gate.pairing import episode_values

    before, after = (episode_values(few[name]) for name in ("base", "worse"))
    assert _capped(narrow, before, after) == 6
    assert _capped(METRICS[0], before, after) == 0
