"""Motion: a random walk whose step is a mixture of Gaussians, and the update it leads to."""

from __future__ import annotations

import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.tracker.hypotheses.parameters import FRAME_S

LARGEST_SD_M = 0.5
EYE = np.eye(3)


def steps(dt_s: float, deviations_m: tuple[float, ...]) -> Floats:
    """Variance (modes,) [m^2] of a displacement in dt_s: deviations grow with the time."""
    sd = np.array(deviations_m) * max(dt_s, 1e-3) / FRAME_S
    return np.minimum(sd, LARGEST_SD_M) ** 2


def spread(dt_s: float, weights: tuple[float, ...], deviations_m: tuple[float, ...]) -> Floats:
    """Covariance (3, 3) [m^2] of a displacement in dt_s."""
    return np.asarray(np.eye(3) * float(np.dot(weights, steps(dt_s, deviations_m))))


def log_likelihood(
    innovation: Floats, S: Floats, weights: tuple[float, ...], variances: Floats
) -> Floats:
    """Log-density (..., modes) [1/m^3] of innovations (..., 3), each mode's weight included.

    S (..., 3, 3) without the motion; variances (modes,) [m^2] of the motion, per axis.
    """
    values, vectors = np.linalg.eigh(S)  # one decomposition serves all modes
    turned = (vectors.swapaxes(-1, -2) @ innovation[..., None])[..., 0]
    total = values[..., None, :] + variances[:, None]  # (..., modes, 3)
    d2 = (turned[..., None, :] ** 2 / total).sum(axis=-1)
    log = np.log(weights) - 0.5 * (d2 + np.log(2 * np.pi * total).sum(axis=-1))
    return np.asarray(log)


def correct(
    mean: Floats,
    P: Floats,
    point: Floats,
    C: Floats,
    dt_s: float,
    weights: tuple[float, ...],
    deviations_m: tuple[float, ...],
) -> tuple[Floats, Floats]:
    """Predict and update a mean (3,) and covariance P (3, 3) with a sighting (3,), C (3, 3).

    Each mode by a Kalman update, then one Gaussian with the moments of their mixture.
    """
    variances = steps(dt_s, deviations_m)
    prior = P + variances[:, None, None] * EYE  # (modes, 3, 3)
    log = log_likelihood(point - mean, P + C, weights, variances)
    weight = np.exp(log - log.max())
    share = weight / weight.sum()
    K = prior @ np.linalg.inv(prior + C)
    means = mean + K @ (point - mean)
    covariances = (EYE - K) @ prior
    centre = np.einsum("k,ki->i", share, means)
    off = means - centre
    total = np.einsum("k,kij->ij", share, covariances) + np.einsum("k,ki,kj->ij", share, off, off)
    return centre, np.asarray(0.5 * (total + total.T))
