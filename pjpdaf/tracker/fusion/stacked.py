"""All views stacked into one update, as printed (Eq. 3.39-3.44)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from pjpdaf.arrays import Floats
from pjpdaf.tracker.association import Association
from pjpdaf.tracker.fusion.fusion import block_diagonal, probabilistic_update, spread_of, stack
from pjpdaf.tracker.fusion.missed import MissedRule
from pjpdaf.tracker.state import Prior


@final
@dataclass(frozen=True)
class Stacked:
    """Eq. 3.39-3.44. A view without a detection counts as an innovation of 0 at full gain.

    detected: leave out the views in which the gate is empty.
    """

    detected: bool = False

    def __call__(
        self, prior: Prior, association: Association, missed: MissedRule
    ) -> tuple[Floats, Floats]:
        """Return mean (T, 6) and covariance (T, 6, 6)."""
        seen, used = association, association.used
        if self.detected:
            used = used & ~seen.empty
        T, N = used.shape
        beta_0 = missed(seen.beta_0, seen.present, used)
        measured = stack(prior, seen.innovation, prior.R, used)
        spread = block_diagonal(spread_of(seen.innovation, seen.theta, used), T, N)
        return probabilistic_update(prior.mean, prior.P, measured, beta_0, spread)
