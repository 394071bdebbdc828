"""Update by the likeliest measurement of each view."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from pjpdaf.arrays import Floats
from pjpdaf.tracker.association import Association
from pjpdaf.tracker.fusion.fusion import stack
from pjpdaf.tracker.fusion.missed import MissedRule
from pjpdaf.tracker.projective import update
from pjpdaf.tracker.state import Prior


@final
@dataclass(frozen=True)
class MostProbable:
    """The likeliest measurement of each view, taken as certain, in a Kalman update (Eq. 3.10-3.12).

    A view takes part where the weight of that measurement is at least `found_mass`.
    """

    def __call__(
        self, prior: Prior, association: Association, missed: MissedRule
    ) -> tuple[Floats, Floats]:
        """Return mean (T, 6) and covariance (T, 6, 6)."""
        used = association.used & (association.beta_best >= association.found_mass)
        measured = stack(prior, association.best, prior.R, used)
        return update(prior.mean, prior.P, measured.innovation, measured.H, measured.R)
