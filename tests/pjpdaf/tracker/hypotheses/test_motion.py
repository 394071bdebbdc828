"""Mixture motion: the update is that of a Kalman filter for one mode, and follows a jump."""

from __future__ import annotations

import numpy as np

from pjpdaf.tracker.hypotheses.motion import correct, log_likelihood, steps
from pjpdaf.tracker.hypotheses.parameters import FRAME_S

P = np.diag([1e-4, 2e-4, 3e-4])
C = np.diag([4e-6, 4e-6, 4e-4])


def test_one_mode_is_a_kalman_update():
    point = np.array([0.01, -0.02, 0.03])
    mean, covariance = correct(np.zeros(3), P, point, C, FRAME_S, (1.0,), (0.08,))
    prior = P + 0.08**2 * np.eye(3)
    K = prior @ np.linalg.inv(prior + C)
    np.testing.assert_allclose(mean, K @ point)
    np.testing.assert_allclose(covariance, (np.eye(3) - K) @ prior, atol=1e-15)


def test_density_is_the_gaussians():
    innovation = np.array([0.01, 0.02, -0.01])
    (found,) = log_likelihood(innovation, P + C, (1.0,), np.array([0.0]))
    S = P + C
    expected = -0.5 * (innovation @ np.linalg.solve(S, innovation))
    expected -= 0.5 * np.log(np.linalg.det(2 * np.pi * S))
    np.testing.assert_allclose(found, expected)


def test_resting_hand_is_smoothed_and_a_fast_hand_followed():
    weights, deviations = (0.3, 0.45, 0.25), (0.012, 0.08, 0.32)
    noise = np.eye(3) * 0.02**2
    still = np.eye(3) * 0.005**2
    rest, _ = correct(np.zeros(3), still, np.full(3, 0.01), noise, FRAME_S, weights, deviations)
    jump, _ = correct(np.zeros(3), still, np.full(3, 0.3), noise, FRAME_S, weights, deviations)
    assert rest.max() < 0.8 * 0.01  # some of the noise is left out
    assert jump.min() > 0.98 * 0.3


def test_displacement_grows_with_the_time_at_any_frame_rate():
    np.testing.assert_allclose(steps(FRAME_S, (0.08,)), 0.08**2)
    np.testing.assert_allclose(steps(FRAME_S / 10, (0.08,)), 0.008**2)
