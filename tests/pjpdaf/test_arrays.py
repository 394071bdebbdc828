"""Median, quantile and mean: the same bits as numpy's."""

from __future__ import annotations

import numpy as np
import pytest

from pjpdaf.arrays import mean_point, median, quantile


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("count", [1, 2, 3, 8, 437, 1000])
def test_median_and_quantile_have_the_bits_of_numpys(count, dtype):
    for seed in range(20):
        values = np.random.default_rng(seed).uniform(-3, 255, count).astype(dtype)
        assert median(values) == np.median(values)
        assert median(values).dtype == dtype
        for share in (0.05, 0.5, 0.95):
            levels = np.rint(values)
            assert quantile(levels, share) == np.percentile(levels, 100 * share)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("count", [1, 2, 7, 300, 1501])
def test_the_mean_of_points_has_the_bits_of_numpys(count, dtype):
    points = np.random.default_rng(count).normal(200.0, 90.0, (count, 2)).astype(dtype)
    np.testing.assert_array_equal(mean_point(points), points.mean(axis=0))


def test_median_of_a_picture_of_several_rows():
    rows = np.random.default_rng(1).normal(size=(9, 14)).astype(np.float32)[::3, ::3]
    assert median(rows) == np.median(rows)
