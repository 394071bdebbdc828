"""All views in one Kalman update, each with the noise of its doubt."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.tracker.association import Association
from pjpdaf.tracker.fusion.fusion import spread_of, stack
from pjpdaf.tracker.fusion.missed import MissedRule
from pjpdaf.tracker.projective import symmetric, update
from pjpdaf.tracker.state import Prior


@final
@dataclass(frozen=True)
class StackedWeighted:
    """One Kalman update in which view n has the noise (R + spread) / (1 - beta_0n).

    The mean of a view's measurements, given that the target's is among them, is z / (1 - beta_0n);
    their spread, Theta / (1 - beta_0n) minus its square, is part of its noise.
    """

    def __call__(
        self, prior: Prior, association: Association, missed: MissedRule
    ) -> tuple[Floats, Floats]:
        """Return mean (T, 6) and covariance (T, 6, 6)."""
        mass = 1.0 - association.beta_0
        used = association.used & (mass > 1e-6)
        weight = np.where(used, mass, 1.0)
        centre = association.innovation / weight[..., None]
        spread = spread_of(centre, association.theta / weight[..., None, None], used)
        R = (prior.R + spread) / weight[..., None, None]
        measured = stack(prior, centre, symmetric(R), used)
        return update(prior.mean, prior.P, measured.innovation, measured.H, measured.R)
