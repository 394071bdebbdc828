"""Protocol of a fusion, and the weighted update of one measurement vector (Eq. 3.41)."""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np

from pjpdaf.arrays import Bools, Floats
from pjpdaf.tracker.association import Association
from pjpdaf.tracker.fusion.missed import MissedRule
from pjpdaf.tracker.projective import gain, innovation_covariance, joseph, symmetric
from pjpdaf.tracker.state import Prior


class Fusion(Protocol):
    """A reading of the update with the measurements of all views."""

    def __call__(
        self, prior: Prior, association: Association, missed: MissedRule
    ) -> tuple[Floats, Floats]:
        """Mean (T, 6) and covariance (T, 6, 6) after the update.

        missed: beta_0 of all views together, for a reading that needs it.
        """
        ...


class MeasurementVector(NamedTuple):
    """A measurement of each target: one view's, or all views' under one another.

    innovation (T, n); H (T, n, 6); R (T, n, n). A view that is left out is zero rows in H.
    """

    innovation: Floats
    H: Floats
    R: Floats


def stack(prior: Prior, innovation: Floats, R: Floats, used: Bools) -> MeasurementVector:
    """Views to one measurement vector (Eq. 3.19, 3.22, 3.39-3.40), n = N r.

    innovation (T, N, r); R (T, N, r, r) or (r, r); used (T, N). R = infinity (Eq. 3.23) is done by
    leaving the view out: with a zero row in H its columns of K are 0, the limit of that rule.
    """
    T, N, r = innovation.shape
    H = np.where(used[:, :, None, None], prior.H, 0.0).reshape(T, N * r, 6)
    innovation = np.where(used[:, :, None], innovation, 0.0).reshape(T, N * r)
    return MeasurementVector(innovation, H, block_diagonal(R, T, N))


def block_diagonal(blocks: Floats, T: int, N: int) -> Floats:
    """Blocks (T, N, r, r) or (r, r) along the diagonal: (T, N r, N r) (Eq. 3.22, 3.43-3.44)."""
    r = blocks.shape[-1]
    full = np.zeros((T, N, r, N, r))
    views = np.arange(N)
    full[:, views, :, views, :] = blocks.swapaxes(0, 1) if blocks.ndim == 4 else blocks
    return full.reshape(T, N * r, N * r)


def spread_of(innovation: Floats, theta: Floats, used: Bools) -> Floats:
    """Theta - Lambda of each view (Eq. 3.43-3.44), (T, N, r, r), 0 where a view is left out."""
    outer = innovation[..., :, None] * innovation[..., None, :]
    return np.where(used[..., None, None], theta - outer, 0.0)


def probabilistic_update(
    mean: Floats, P: Floats, measured: MeasurementVector, beta_0: Floats, spread: Floats
) -> tuple[Floats, Floats]:
    """State and covariance with uncertain origins (Eq. 3.10, 3.12, 3.41).

    beta_0 (T,); spread (T, n, n) = Theta - Lambda. Eq. 3.41 takes (1 - beta_0) K S K^T from P:
    for beta_0 <= 1 that is beta_0 P + (1 - beta_0) (I - K H) P, with Joseph's form for the latter;
    beta_0 > 1 (the printed sum of Eq. 3.42) adds to P instead.
    """
    S = innovation_covariance(measured.H, P, measured.R)
    K = gain(P, measured.H, S)
    moved = mean + (K @ measured.innovation[..., None])[..., 0]
    share = 1.0 - beta_0[:, None, None]
    KT = K.swapaxes(-1, -2)
    kept = (1.0 - share) * P + share * joseph(P, K, measured.H, measured.R)
    if share.min() < 0.0:
        kept = np.where(share < 0.0, P - share * (K @ S @ KT), kept)
    return moved, symmetric(kept + K @ spread @ KT)
