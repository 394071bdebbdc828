"""Update by the views one after another."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.tracker.association import Association
from pjpdaf.tracker.fusion.fusion import MeasurementVector, probabilistic_update
from pjpdaf.tracker.fusion.missed import MissedRule
from pjpdaf.tracker.state import Prior


@final
@dataclass(frozen=True)
class Sequential:
    """Each view's own PDA update in turn, all linearised and associated at the prediction."""

    def __call__(
        self, prior: Prior, association: Association, missed: MissedRule
    ) -> tuple[Floats, Floats]:
        """Return mean (T, 6) and covariance (T, 6, 6)."""
        seen, mean, P = association, prior.mean, prior.P
        used = seen.used.astype(float)  # 0 makes a view do nothing
        all_H = prior.H * used[:, :, None, None]
        masses = (1.0 - seen.beta_0) * used
        R = np.repeat(prior.R[None], len(mean), axis=0)
        for n in range(used.shape[1]):
            H, mass = all_H[:, n], masses[:, n, None]
            innovation = seen.innovation[:, n] * used[:, n, None]
            theta = seen.theta[:, n] * used[:, n, None, None]
            if n:  # innovation from the prediction -> from the state after the earlier views
                shift = (H @ (mean - prior.mean)[..., None])[..., 0]
                cross = shift[:, :, None] * innovation[:, None, :]
                again = (mass * shift)[:, :, None] * shift[:, None, :]
                theta = theta - cross - cross.swapaxes(1, 2) + again
                innovation = innovation - mass * shift
            spread = theta - innovation[:, :, None] * innovation[:, None, :]
            measured = MeasurementVector(innovation, H, R)
            mean, P = probabilistic_update(mean, P, measured, 1.0 - mass[:, 0], spread)
        return mean, P
