"""Against SciPy's function: the same pairs, of equally cheap ones too."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linear_sum_assignment

from reports.score.assignment import assignment


@settings(max_examples=400, deadline=None)
@given(st.integers(0, 7), st.integers(0, 7), st.sampled_from([0, 1, 2, 5, None]), st.integers(0))
def test_the_pairs_are_scipys(rows, columns, most, seed):
    rng = np.random.default_rng(seed)
    size = rows, columns
    # Small whole numbers: many choices cost the same.
    cost = rng.normal(size=size) if most is None else rng.integers(-most, most + 1, size)
    for mine, theirs in zip(assignment(cost), linear_sum_assignment(cost), strict=True):
        assert mine.tolist() == theirs.tolist()


def test_costs_at_a_cut_off_are_alike():
    rng = np.random.default_rng(1)
    for _ in range(300):
        cost = np.minimum(rng.uniform(0, 0.3, (3, 4)), 0.15) ** 2.0
        for mine, theirs in zip(assignment(cost), linear_sum_assignment(cost), strict=True):
            assert mine.tolist() == theirs.tolist()


@pytest.mark.parametrize("wrong", [np.nan, np.inf])
def test_costs_that_are_none_are_refused(wrong):
    with pytest.raises(ValueError, match="finite"):
        assignment(np.array([[1.0, wrong]]))
