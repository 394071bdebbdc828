"""The correction on a simulated pair of fast and full outcomes."""

from __future__ import annotations

import numpy as np
import pytest

from scenarios.stress.estimate.correction import FullRuns, allocation, corrected
from scenarios.stress.estimate.probability import counted

N, FULL = 2000, 60


def simulated(
    rng: np.random.Generator, fast_p: float, right: float, missed: float
) -> tuple[float, float, float, bool]:
    """Estimate, interval, and whether it covers, of a stand-in that is wrong now and then."""
    fast = counted(int(rng.binomial(N, fast_p)), N)
    first, rest = allocation(fast, FULL)
    failing = FullRuns(first, int(rng.binomial(first, right)))
    passing = FullRuns(rest, int(rng.binomial(rest, missed)))
    result = corrected(fast, failing, passing)
    truth = fast_p * right + (1 - fast_p) * missed
    return result.p, result.low, result.high, result.low <= truth <= result.high


@pytest.mark.parametrize(
    ("fast_p", "right", "missed"),
    [(0.1, 0.8, 0.01), (0.3, 0.6, 0.05), (0.02, 0.9, 0.0), (0.5, 0.1, 0.3)],
)
def test_interval_covers_and_the_estimate_is_unbiased(
    fast_p: float, right: float, missed: float
) -> None:
    rng = np.random.default_rng(1)
    results = [simulated(rng, fast_p, right, missed) for _ in range(60)]
    truth = fast_p * right + (1 - fast_p) * missed
    assert sum(covers for *_, covers in results) > 51  # of 60, at 95 %
    spread = np.std([p for p, *_ in results])
    # Four standard errors of the mean of 60.
    assert abs(np.mean([p for p, *_ in results]) - truth) <= 4 * spread / np.sqrt(60)


def test_it_is_sharper_than_the_full_runs_alone_where_fast_predicts_them() -> None:
    rng = np.random.default_rng(2)
    right, missed, fast_p = 0.95, 0.02, 0.3
    truth = fast_p * right + (1 - fast_p) * missed
    spread = np.std([simulated(rng, fast_p, right, missed)[0] for _ in range(60)])
    assert spread < 0.75 * np.sqrt(truth * (1 - truth) / FULL)


def test_agreement_in_every_run_leaves_an_interval() -> None:
    result = corrected(counted(100, 1000), FullRuns(20, 20), FullRuns(20, 0))
    assert result.p == pytest.approx(0.1)
    assert result.high - result.low > 0.03
    assert result.conclusive


def test_a_side_that_was_not_tried_is_not_conclusive() -> None:
    fast = counted(300, 1000)
    assert not corrected(fast, FullRuns(0, 0), FullRuns(20, 0)).conclusive
    assert not corrected(fast, FullRuns(20, 20), FullRuns(0, 0)).conclusive
    assert corrected(counted(0, 1000), FullRuns(0, 0), FullRuns(40, 0)).conclusive
    # What is rare enough need not be tried: the interval allows for all of it.
    result = corrected(counted(100, 1000), FullRuns(0, 0), FullRuns(40, 0))
    assert result.conclusive
    assert result.p == pytest.approx(0.1)
    assert result.high > 0.1


def test_nothing_failed_anywhere_is_a_bound() -> None:
    result = corrected(counted(0, 1000), FullRuns(0, 0), FullRuns(40, 0))
    assert (result.p, result.low) == (0.0, 0.0)
    assert 0.02 < result.high < 0.1


def test_allocation_goes_no_further_than_there_are_failures() -> None:
    assert allocation(counted(3, 1000), 60) == (3, 57)
    assert allocation(counted(0, 1000), 60) == (0, 60)
    first, rest = allocation(counted(300, 1000), 60)
    assert first + rest == 60
    assert first >= 12
    assert rest >= 12
