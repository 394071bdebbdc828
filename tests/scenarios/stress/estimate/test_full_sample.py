"""The draws that are played in full follow the distribution, not the proposal."""

from __future__ import annotations

import numpy as np

from scenarios.stress.estimate.estimate import Sample
from scenarios.stress.estimate.full_sample import failing_draws, passing_draws
from scenarios.stress.estimate.outcomes import Outcomes


def sample(failed: np.ndarray, weights: np.ndarray, nominal: int) -> Sample:
    n = len(failed)
    outcomes = Outcomes(failed, np.zeros(n), np.ones(n, dtype=bool))
    return Sample(np.zeros((n, 2)), np.arange(n), outcomes, weights, nominal)


def test_failures_of_equal_weight_come_once_each() -> None:
    failed = np.arange(200) % 4 == 0
    chosen = failing_draws(sample(failed, np.ones(200), 200), 30, 1)
    assert len(set(chosen)) == 30
    assert failed[chosen].all()


def test_a_heavy_failure_comes_as_often_as_it_weighs() -> None:
    weights = np.where(np.arange(100) < 10, 9.0, 1.0)  # half of the weight in a tenth
    drawn = [failing_draws(sample(np.ones(100, bool), weights, 0), 18, s) for s in range(50)]
    heavy = np.mean([np.mean(np.array(chosen) < 10) for chosen in drawn])
    assert abs(heavy - 0.5) < 0.03


def test_passes_are_nominal() -> None:
    failed = np.arange(10) % 2 == 0
    assert passing_draws(sample(failed, np.ones(10), 6), 8) == [1, 3, 5]
    assert failing_draws(sample(np.zeros(10, bool), np.ones(10), 10), 5, 0) == []
