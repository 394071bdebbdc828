"""The fit of a proposal to failures, by weighted expectation maximisation."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Floats
from scenarios.stress.estimate.proposal import Proposal

LEAST_SD, MOST_SD = 0.4, 3.0
# Standard errors by which a coordinate must differ; and what keeps the tails above those of p.
DIFFERS, WIDER = 3.0, 1.15
MOST_COMPONENTS = 3
_STEPS = 25


def fitted(latents: Floats, weights: Floats) -> Proposal:
    """Fit a mixture of axis-aligned Gaussians to weighted latents (n, d).

    A coordinate stays nominal unless its mean or its variance differs by more than three standard
    errors: of thirty parameters a few matter, and the noise of the others would only spread the
    weights. The number of components, for failures of several kinds, is that of the least BIC.
    """
    share = weights / weights.sum()
    effective = 1.0 / float(np.sum(share**2))
    mean = share @ latents
    variance = share @ (latents - mean) ** 2
    matters = (np.abs(mean) > DIFFERS / math.sqrt(effective)) | (
        np.abs(variance - 1.0) > DIFFERS * math.sqrt(2.0 / effective)
    )
    chosen = latents[:, matters]
    best: tuple[float, Floats, Floats, Floats] | None = None
    for K in range(1, MOST_COMPONENTS + 1):
        if effective < 8 * K:
            break
        shares, means, sds, likelihood = _mixture(chosen, share, K)
        parameters = K * (1 + 2 * chosen.shape[1]) - 1
        criterion = parameters * math.log(effective) - 2.0 * effective * likelihood
        if best is None or criterion < best[0]:
            best = criterion, shares, means, sds
    if best is None:
        best = 0.0, *_mixture(chosen, share, 1)[:3]
    _, shares, means, sds = best
    full_means = np.zeros((len(shares), latents.shape[1]))
    full_sds = np.ones_like(full_means)
    full_means[:, matters], full_sds[:, matters] = means, WIDER * sds
    return Proposal(shares, full_means, full_sds)


def _mixture(points: Floats, share: Floats, K: int) -> tuple[Floats, Floats, Floats, float]:
    """Shares (K,), means and sds (K, s), and the mean log-likelihood of weighted points (n, s)."""
    belongs = np.eye(K)[_clusters(points, share, K)]
    likelihood = 0.0
    for _ in range(_STEPS if K > 1 else 1):
        mass = share[:, None] * belongs
        shares = np.maximum(mass.sum(axis=0), 1e-6)
        shares = shares / shares.sum()
        portions = mass / np.maximum(mass.sum(axis=0), 1e-12)
        means = portions.T @ points
        squares = portions.T @ points**2 - means**2
        sds = np.clip(np.sqrt(np.maximum(squares, 0.0)), LEAST_SD, MOST_SD)
        scaled = (points[:, None] - means) / sds
        log_parts = np.log(shares) - 0.5 * np.sum(scaled**2, axis=2) - np.log(sds).sum(axis=1)
        log_sum = np.logaddexp.reduce(log_parts, axis=1)
        likelihood = float(share @ log_sum)
        belongs = np.exp(log_parts - log_sum[:, None])
    return shares, means, sds, likelihood


def _clusters(points: Floats, share: Floats, K: int) -> NDArray[np.intp]:
    """The nearest of K centres of each point: the mean's farthest, then farthest from these."""
    if K == 1:
        return np.zeros(len(points), dtype=np.intp)
    far = np.linalg.norm(points - share @ points, axis=1)
    centres = [points[int(far.argmax())]]
    for _ in range(K - 1):
        far = np.min([np.linalg.norm(points - c, axis=1) for c in centres], axis=0)
        centres.append(points[int(far.argmax())])
    distances = np.stack([np.linalg.norm(points - c, axis=1) for c in centres], axis=1)
    return np.asarray(distances.argmin(axis=1))
