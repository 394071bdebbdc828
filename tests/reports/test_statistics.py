import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import bootstrap

from reports.statistics import holm, mcnemar, paired_bootstrap, wilson


def test_the_interval_is_that_of_scipys_bootstrap():
    values = np.random.default_rng(1).gamma(2.0, 3.0, 60) - 4.0
    ours = paired_bootstrap(values, ["a"] * 60, np.random.default_rng(2), resamples=20_000)
    theirs = bootstrap(
        (values,), np.mean, n_resamples=20_000, method="percentile", rng=np.random.default_rng(3)
    ).confidence_interval
    spread = values.std() / math.sqrt(60)
    assert ours.mean == pytest.approx(values.mean())
    assert ours.low == pytest.approx(theirs.low, abs=0.1 * spread)
    assert ours.high == pytest.approx(theirs.high, abs=0.1 * spread)


def test_what_differs_only_between_strata_does_not_widen_the_interval():
    values = np.array([0.0] * 20 + [10.0] * 20)
    strata = ["calm"] * 20 + ["fast"] * 20
    within = paired_bootstrap(values, strata, np.random.default_rng(0))
    across = paired_bootstrap(values, ["all"] * 40, np.random.default_rng(0))
    assert within.low == within.high == within.mean == 5.0
    assert across.high - across.low > 2.0


def test_strata_of_one_episode_are_pooled():
    values = np.array([1.0, 2.0, 3.0, 4.0, 5.0])
    found = paired_bootstrap(values, list("abcde"), np.random.default_rng(0))
    assert found.low < 2.0 < 4.0 < found.high


def test_coverage_of_the_true_difference():
    hits = 0
    for seed in range(300):
        rng = np.random.default_rng(seed)
        values = rng.normal(0.4, 1.0, 60)
        found = paired_bootstrap(values, ["a"] * 30 + ["b"] * 30, rng, resamples=999)
        hits += found.low <= 0.4 <= found.high
    low, high = wilson(hits, 300)
    assert low <= 0.95 <= high or 0.92 < hits / 300 < 0.98


def test_no_difference_at_all_is_no_evidence():
    found = paired_bootstrap(np.zeros(9), ["a"] * 9, np.random.default_rng(0))
    assert (found.mean, found.low, found.high, found.p_worse) == (0.0, 0.0, 0.0, 1.0)


@pytest.mark.parametrize("bad", [np.zeros(0), np.array([1.0, np.nan])])
def test_nothing_or_nan_is_refused(bad):
    with pytest.raises(ValueError, match="finite differences"):
        paired_bootstrap(bad, ["a"] * len(bad), np.random.default_rng(0))


def test_mcnemar_counts_only_what_differs():
    base = [False] * 50 + [True] * 50 + [False] * 8 + [True] * 1
    new = [False] * 50 + [True] * 50 + [True] * 8 + [False] * 1
    # P(X >= 8) of 9 fair coins.
    assert mcnemar(base, new) == pytest.approx((9 + 1) / 2**9)
    assert mcnemar(new, base) == pytest.approx(1 - 1 / 2**9)
    assert mcnemar(base, base) == 1.0


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
