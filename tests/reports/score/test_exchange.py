"""Stated exchange probabilities against what was."""

import numpy as np
import pytest

from reports.score.exchange import Exchange, calibration_error, exchange_of, exchanged, reliability


def test_hands_near_each_other_or_without_estimate_are_neither(tools):
    truths = tools.paths(5, 3.0)
    estimates = truths.copy()
    estimates[1] = estimates[1, [0, 2, 1]]
    estimates[2, 2] = np.nan
    truths[3, 2] = truths[3, 1] + [0.0, 0.099, 0.0]
    np.testing.assert_array_equal(exchanged(truths, estimates), [0, 1, np.nan, np.nan, 0])


def test_an_episode_has_its_trackers_statement(episode_of, tools):
    centres = tools.paths(4, 3.0)
    stated = np.array([0.1, np.nan, 0.4, 0.2])
    estimates = centres.copy()
    estimates[2] = estimates[2, [0, 2, 1]]
    judged = exchange_of(episode_of(estimates, centres_m=centres, exchange=stated)).judged
    np.testing.assert_array_equal(judged.stated, [0.1, 0.4, 0.2])
    np.testing.assert_array_equal(judged.exchanged, [0, 1, 0])


def test_bins_and_calibration_error_by_hand():
    stated = np.array([0.0, 0.1, 0.3, 0.3, 0.5, 1.0, np.nan])
    happened = np.array([0.0, 1.0, 0.0, 1.0, np.nan, 1.0, 1.0])
    low, middle, high = reliability(Exchange(stated, happened), (0.0, 0.25, 0.5, 1.0))
    assert (low.frames, low.stated, low.observed) == (2, 0.05, 0.5)
    assert (middle.frames, middle.stated, middle.observed) == (2, 0.3, 0.5)
    assert (high.frames, high.stated, high.observed) == (1, 1.0, 1.0)
    assert calibration_error((low, middle, high)) == pytest.approx((2 * 0.45 + 2 * 0.2) / 5)
    assert np.isnan(calibration_error(()))


def test_a_calibrated_statement_has_a_small_error():
    rng = np.random.default_rng(4)
    stated = rng.uniform(0, 0.6, 40_000)
    happened = (rng.uniform(size=stated.size) < stated).astype(float)
    assert calibration_error(reliability(Exchange(stated, happened))) < 0.01
    assert calibration_error(reliability(Exchange(stated**2, happened))) > 0.1
