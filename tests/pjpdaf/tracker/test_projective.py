"""Equations of the Kalman filter against a textbook filter and Stone Soup."""

from __future__ import annotations

from datetime import datetime

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from stonesoup.models.measurement.linear import LinearGaussian
from stonesoup.types.detection import Detection
from stonesoup.types.hypothesis import SingleHypothesis
from stonesoup.types.prediction import GaussianStatePrediction
from stonesoup.updater.kalman import KalmanUpdater
from strategies import START_W, calm, rig

from pjpdaf.camera import project
from pjpdaf.presets.registry import PRESETS
from pjpdaf.tracker.measurement import MEASUREMENT_MODELS as MODELS
from pjpdaf.tracker.measurement import Projection, linearise
from pjpdaf.tracker.process import process_noise, transition
from pjpdaf.tracker.projective import homogeneous, innovation_covariance, predict, update
from pjpdaf.tracker.start import start_covariance
from pjpdaf.tracker.thesis_units import FRAME_S

CAMERAS = rig().cameras
LITERAL = PRESETS["thesis-literal"].tracker
PRINTED = LITERAL.process


def spd(rng: np.random.Generator, n: int) -> np.ndarray:
    A = rng.normal(size=(n, n))
    return A @ A.T + 0.1 * np.eye(n)


def textbook(
    x: np.ndarray, P: np.ndarray, z: np.ndarray, Q: np.ndarray, literal: bool
) -> tuple[np.ndarray, np.ndarray]:
    """One step of Eq. 3.7-3.14 with the printed eight states and three rows a view, in loops."""
    F = np.eye(8)
    F[[0, 1, 2], [4, 5, 6]] = FRAME_S
    x, P = F @ x, F @ P @ F.T + Q
    rows, predicted, R = [], [], []
    for camera in CAMERAS:
        q = camera.M @ x[:4]
        M = camera.M.copy()
        if not literal:  # the Jacobian
            M[:2] -= (q[:2] / q[2])[:, None] * M[2]
            M[2] = 0.0
        rows.append(np.hstack([M / q[2], np.zeros((3, 4))]))
        predicted.append(q / q[2])
        R += [15.0, 15.0, 0.5]
    H = np.vstack(rows)
    S = H @ P @ H.T + np.diag(R)
    K = P @ H.T @ np.linalg.inv(S)
    full = np.column_stack([z, np.ones(len(z))]).ravel()
    return x + K @ (full - np.ravel(predicted)), (np.eye(8) - K @ H) @ P


@pytest.mark.parametrize("measurement", ["thesis", "jacobian"])
def test_equal_to_the_textbook_filter_with_the_printed_state(measurement) -> None:
    rng = np.random.default_rng(8)
    kept = [0, 1, 2, 4, 5, 6]
    Q = np.zeros((8, 8))
    Q[np.ix_(kept, kept)] = process_noise(PRINTED, FRAME_S)
    P8 = np.zeros((8, 8))
    P8[np.ix_(kept, kept)] = start_covariance(LITERAL.start)
    x, P = np.append(calm(0.0)[1], np.zeros(3)), start_covariance(LITERAL.start)
    x8 = homogeneous(x)
    projection = Projection.of(CAMERAS, MODELS[measurement])
    for k in range(1, 30):
        point = calm(k * FRAME_S)[1]
        z = np.array([project(camera, point) for camera in CAMERAS]) + rng.normal(0, 2, (2, 2))
        x8, P8 = textbook(x8, P8, z, Q, measurement == "thesis")
        (x,), (P,) = predict(x[None], P[None], transition(FRAME_S), process_noise(PRINTED, FRAME_S))
        expected, H, _ = linearise(projection, x[None, :3], third_row=True)
        innovation = np.column_stack([z - expected[:, 0], np.zeros(2)]).ravel()
        R = np.diag([15.0, 15.0, 0.5] * 2)
        x, P = update(x, P, innovation, H[:, 0].reshape(6, 6), R)
        np.testing.assert_allclose(homogeneous(x), x8, atol=1e-9)
        np.testing.assert_allclose(P, P8[np.ix_(kept, kept)], atol=1e-12)
    assert np.all(P8[[3, 7]] == 0.0)  # the constants have no variance, ever


def test_equal_to_stone_soup_on_linear_problems() -> None:
    rng = np.random.default_rng(14)
    for _ in range(50):
        x, P = rng.normal(size=6), spd(rng, 6)
        H, R = rng.normal(size=(4, 6)), spd(rng, 4)
        z = rng.normal(size=4)
        # Stone Soup's LinearGaussian picks states: the problem is turned so that H picks them.
        model = LinearGaussian(6, (0, 1, 2, 3), R)
        A = np.vstack([H, rng.normal(size=(2, 6))])
        prior = GaussianStatePrediction(A @ x, A @ P @ A.T, timestamp=datetime(2009, 1, 1))
        seen = Detection(z, measurement_model=model)
        theirs = KalmanUpdater(model).update(SingleHypothesis(prior, seen))
        ours, covariance = update(x, P, z - H @ x, H, R)
        np.testing.assert_allclose(A @ ours, np.ravel(theirs.state_vector), atol=1e-9)
        np.testing.assert_allclose(A @ covariance @ A.T, theirs.covar, atol=1e-8)


@given(st.integers(0, 2**32 - 1))
def test_update_keeps_the_covariance_symmetric_positive_and_no_larger(seed: int) -> None:
    rng = np.random.default_rng(seed)
    P, H, R = spd(rng, 6), 10 ** rng.uniform(-2, 3) * rng.normal(size=(4, 6)), spd(rng, 4)
    _, after = update(np.zeros(6), P, rng.normal(size=4), H, R)
    np.testing.assert_array_equal(after, after.T)
    assert np.linalg.eigvalsh(after)[0] > 0
    # 1e-9: rounding beside eigenvalues of up to about 50.
    assert np.linalg.eigvalsh(P - after)[0] > -1e-9


def test_a_static_target_converges_in_every_reading() -> None:
    """Why the missing term goes unseen: at rest even the wrong H ends at the right place."""
    truth = START_W[1]
    for name in ("thesis", "jacobian"):
        x, P = (
            np.concatenate([truth + np.array([0.02, -0.02, 0.02]), np.zeros(3)]),
            start_covariance(LITERAL.start),
        )
        projection = Projection.of(CAMERAS, MODELS[name])
        for _ in range(300):
            (x,), (P,) = predict(x[None], P[None], transition(FRAME_S), process_noise(PRINTED, 1))
            z, H, _ = linearise(projection, x[None, :3], third_row=False)
            innovation = np.array([project(c, truth) for c in CAMERAS]) - z[:, 0]
            x, P = update(x, P, innovation.ravel(), H[:, 0].reshape(4, 6), 15.0 * np.eye(4))
        assert np.linalg.norm(x[:3] - truth) < 0.005


def test_innovation_covariance_is_equation_3_14() -> None:
    rng = np.random.default_rng(1)
    H, P, R = rng.normal(size=(4, 6)), spd(rng, 6), spd(rng, 4)
    np.testing.assert_allclose(innovation_covariance(H, P, R), H @ P @ H.T + R)
