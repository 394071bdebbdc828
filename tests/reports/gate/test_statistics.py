import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import bootstrap, permutation_test
from scipy.stats import t as student

from reports.gate.statistics import clustered_bootstrap, holm, mcnemar, sign_flip, wilson


def interval(values, draws=None, strata=None, seed=0, **options):
    values = np.asarray(values, dtype=float)
    draws = range(len(values)) if draws is None else draws
    strata = ["all"] * len(values) if strata is None else strata
    rng = np.random.default_rng(seed)
    return clustered_bootstrap(values, list(draws), strata, rng, **options)


def test_the_interval_is_that_of_scipys_bootstrap():
    values = np.random.default_rng(1).gamma(2.0, 3.0, 200) - 4.0
    ours = interval(values, resamples=20_000)
    theirs = bootstrap(
        (values,), np.mean, n_resamples=20_000, method="percentile", rng=np.random.default_rng(3)
    ).confidence_interval
    spread = values.std() / math.sqrt(200)
    assert ours.mean == pytest.approx(values.mean())
    assert ours.low == pytest.approx(theirs.low, abs=0.1 * spread)
    assert ours.high == pytest.approx(theirs.high, abs=0.1 * spread)
    assert (ours.n, ours.draws) == (200, 200)


def test_of_few_normal_values_it_is_about_students():
    ratios = []
    for seed in range(40):
        values = np.random.default_rng(seed).normal(0, 1, 6)
        half = student.ppf(0.975, 5) * values.std(ddof=1) / math.sqrt(6)
        found = interval(values, seed=seed, resamples=2000)
        ratios.append((found.high - found.low) / (2 * half))
    # Fewer than 6 different values have thinner tails than Student's curve.
    assert 0.75 < np.mean(ratios) < 1.05


def test_what_differs_only_between_strata_does_not_widen_the_interval():
    values = np.array([0.0] * 20 + [10.0] * 20)
    strata = ["calm"] * 20 + ["fast"] * 20
    within, across = interval(values, strata=strata), interval(values)
    assert within.low == within.high == within.mean == 5.0
    assert across.high - across.low > 2.0


def test_strata_of_one_draw_are_pooled_also_a_single_one():
    found = interval([1.0, 2.0, 3.0, 4.0, 5.0], strata=list("abcde"))
    assert found.low < 2.0 < 4.0 < found.high
    single = interval([0.0] * 10 + [8.0], strata=["a"] * 10 + ["b"])
    assert single.low < single.mean < single.high


def test_episodes_of_a_draw_count_once():
    rng = np.random.default_rng(4)
    values = rng.normal(0, 1, 30)
    once, thrice = interval(values), interval(np.repeat(values, 3), np.repeat(np.arange(30), 3))
    assert thrice.mean == pytest.approx(once.mean)
    assert thrice.low == pytest.approx(once.low, abs=0.03)
    assert thrice.high == pytest.approx(once.high, abs=0.03)
    assert (thrice.n, thrice.draws) == (90, 30)
    wrong = interval(np.repeat(values, 3))
    assert wrong.high - wrong.low < 0.65 * (thrice.high - thrice.low)


def test_a_draw_that_spans_strata_is_one_draw():
    values = np.random.default_rng(5).normal(0, 1, 40)
    draws = [k // 2 for k in range(40)]
    found = interval(values, draws, ["calm", "fast"] * 20)
    plain = interval(values, draws)
    assert found.draws == 20
    assert found.high - found.low == pytest.approx(plain.high - plain.low, rel=0.05)


@pytest.mark.parametrize(("n", "per_draw"), [(60, 1), (60, 4), (8, 1)])
def test_coverage_of_the_true_difference(n, per_draw):
    hits, tries = 0, 400
    for seed in range(tries):
        rng = np.random.default_rng(seed)
        draws = np.repeat(np.arange(n // per_draw), per_draw)
        values = rng.normal(0.4, 1.0, n // per_draw)[draws] + rng.normal(0, 0.3, n)
        strata = np.where(draws % 2, "a", "b").tolist()
        found = interval(values, draws.tolist(), strata, seed, resamples=999)
        hits += found.low <= 0.4 <= found.high
    assert 0.92 <= hits / tries <= 0.99


def test_one_draw_says_nothing_about_the_spread():
    found = interval([3.0, 4.0], draws=[0, 0])
    assert (found.mean, found.low, found.high) == (3.5, -math.inf, math.inf)


def test_no_difference_at_all_is_no_evidence():
    found = interval(np.zeros(9))
    assert (found.mean, found.low, found.high) == (0.0, 0.0, 0.0)
    assert sign_flip(np.zeros(9), range(9), np.random.default_rng(0)) == 1.0


@pytest.mark.parametrize("bad", [np.zeros(0), np.array([1.0, np.nan]), np.array([1.0, np.inf])])
def test_nothing_or_nan_is_refused(bad):
    with pytest.raises(ValueError, match="finite differences"):
        interval(bad)


def test_sign_flips_are_scipys_permutation_test():
    values = np.random.default_rng(6).normal(0.5, 1.0, 9)
    theirs = permutation_test(
        (values, np.zeros(9)),
        lambda a, b: np.sum(a - b),
        permutation_type="samples",
        alternative="greater",
        n_resamples=math.inf,
    ).pvalue
    rng = np.random.default_rng(0)
    assert sign_flip(values, range(9), rng) == pytest.approx(theirs)
    drawn = sign_flip(values, range(9), rng, resamples=500)
    assert drawn == pytest.approx(theirs, abs=0.06)


def test_few_draws_cannot_be_significant():
    rng = np.random.default_rng(0)
    assert sign_flip(np.array([9.0, 9.0, 9.0]), range(3), rng) == 1 / 8
    # Twelve episodes, but three draws.
    assert sign_flip(np.full(12, 9.0), [k // 4 for k in range(12)], rng) == 1 / 8


def test_sign_flips_keep_their_promise_with_heavy_tails():
    alarms = 0
    for seed in range(1000):
        rng = np.random.default_rng(seed)
        values = rng.standard_cauchy(15)
        alarms += sign_flip(values, range(15), rng, resamples=499) < 0.05
    assert wilson(alarms, 1000)[0] <= 0.05


def test_mcnemar_counts_only_what_differs():
    changes = np.array([0.0] * 100 + [1.0] * 8 + [-1.0])
    # P(X >= 8) of 9 fair coins.
    assert mcnemar(changes, range(109)) == pytest.approx((9 + 1) / 2**9)
    assert mcnemar(-changes, range(109)) == pytest.approx(1 - 1 / 2**9)
    assert mcnemar(np.zeros(5), range(5)) == 1.0


def test_in_mcnemar_a_draw_votes_once():
    changes = np.array([1.0, 1.0, 1.0, 1.0, -1.0, 1.0])
    assert mcnemar(changes, [0, 0, 0, 0, 1, 1]) == 0.5  # one vote; the other draw is undecided


def test_holm_by_a_worked_example():
    assert holm([0.01, 0.04, 0.03, 0.005]) == pytest.approx((0.03, 0.06, 0.06, 0.02))


@given(st.lists(st.floats(0, 1), min_size=1, max_size=12))
def test_holm_keeps_order_and_never_makes_a_p_value_smaller(p_values):
    adjusted = holm(p_values)
    assert all(a >= p and a <= 1 for a, p in zip(adjusted, p_values, strict=True))
    order = np.argsort(p_values, kind="stable")
    assert all(np.diff(np.array(adjusted)[order]) >= 0)


def test_wilson_of_nothing_says_nothing():
    assert wilson(0, 0) == (0.0, 1.0)
    low, high = wilson(0, 10)
    assert low == 0.0
    assert high == pytest.approx(0.2775, abs=1e-3)
