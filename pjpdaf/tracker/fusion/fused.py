"""Update by each view apart, their information added up."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.tracker.association import Association
from pjpdaf.tracker.fusion.fusion import spread_of
from pjpdaf.tracker.fusion.missed import MissedRule
from pjpdaf.tracker.projective import symmetric
from pjpdaf.tracker.state import Prior


@final
@dataclass(frozen=True)
class Fused:
    """Each view's own PDA update of the prediction (Eq. 3.41), their information added up.

    P^-1 = P0^-1 + sum_n (P_n^-1 - P0^-1), P0 the prediction's, and the same for P^-1 x: exact where
    origins are certain, and the order of the views does not matter. A view whose doubt leaves P_n
    above P0 in some direction adds nothing there instead of taking information away, so P stays
    positive. Worked in coordinates in which P0 is the identity.
    """

    def __call__(
        self, prior: Prior, association: Association, missed: MissedRule
    ) -> tuple[Floats, Floats]:
        """Return mean (T, 6) and covariance (T, 6, 6)."""
        seen, used = association, association.used
        root = np.linalg.cholesky(prior.P)  # P0 = root root^T
        z = np.where(used[..., None], seen.innovation, 0.0)
        H = prior.H @ root[:, None]  # (T, N, r, 6)
        HT = H.swapaxes(-1, -2)
        K = HT @ np.linalg.inv(H @ HT + prior.R)
        detected = np.where(used, 1.0 - seen.beta_0, 0.0)[..., None, None]
        I = np.eye(H.shape[-1])  # noqa: E741
        P = I - detected * (K @ H) + K @ spread_of(z, seen.theta, used) @ K.swapaxes(-1, -2)
        variances, axes = np.linalg.eigh(P)  # reads one triangle
        gains = np.maximum(1.0 / variances, 1.0)[..., None, :]
        information = (axes * gains) @ axes.swapaxes(-1, -2)
        pulled = (information @ (K @ z[..., None])).sum(axis=1)
        P = root @ np.linalg.inv(I + (information - I).sum(axis=1))
        return prior.mean + (P @ pulled)[..., 0], symmetric(P @ root.swapaxes(-1, -2))
