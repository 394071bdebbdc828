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
    return mixed(*updated(mean, P, point, C, weights, steps(dt_s, deviations_m)))


def updated(
    mean: Floats, P: Floats, point: Floats, C: Floats, weights: tuple[float, ...], variances: Floats
) -> tuple[Floats, Floats, Floats]:
    """Update as `correct` does, any number at once, of (..., 3) and (..., 3, 3), mode by mode.

    variances (modes,) [m^2] of the motion, per axis. Returns the modes' probabilities (..., modes),
    means (..., modes, 3) and covariances (..., modes, 3, 3).
    """
    prior = P[..., None, :, :] + variances[:, None, None] * EYE
    S = prior + C[..., None, :, :]
    innovation = point - mean
    log = log_likelihood(innovation, P + C, weights, variances)
    weight = np.exp(log - log.max(axis=-1, keepdims=True))
    K = prior @ np.linalg.inv(S)
    means = mean[..., None, :] + (K @ innovation[..., None, :, None])[..., 0]
    return weight / weight.sum(axis=-1, keepdims=True), means, (EYE - K) @ prior


def mixed(share: Floats, means: Floats, covariances: Floats) -> tuple[Floats, Floats]:
    """Mean (3,) and covariance (3, 3) of a mixture of Gaussians, (modes,), (modes, 3), ..."""
    centre = np.einsum("k,ki->i", share, means)
    off = means - centre
    total = np.einsum("k,kij->ij", share, covariances) + np.einsum("k,ki,kj->ij", share, off, off)
    return centre, np.asarray(0.5 * (total + total.T))
