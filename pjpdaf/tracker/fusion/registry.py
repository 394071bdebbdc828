"""The fusions by name, and their parameters."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from pjpdaf.tracker.fusion.fused import Fused
from pjpdaf.tracker.fusion.fusion import Fusion
from pjpdaf.tracker.fusion.missed import MissedRule, ProductOfViews
from pjpdaf.tracker.fusion.most_probable import MostProbable
from pjpdaf.tracker.fusion.sequential import Sequential
from pjpdaf.tracker.fusion.stacked import Stacked
from pjpdaf.tracker.fusion.stacked_weighted import StackedWeighted

FUSIONS: Mapping[str, Fusion] = {
    "stacked": Stacked(),
    "stacked_detected": Stacked(detected=True),
    "stacked_weighted": StackedWeighted(),
    "sequential": Sequential(),
    "fused": Fused(),
    "most_probable": MostProbable(),
}


@dataclass(frozen=True)
class FusionParameters:
    """Update with the measurements of all views (Eq. 3.39-3.44)."""

    update: Fusion = field(default_factory=Fused)
    # beta_0 of Eq. 3.42, for `Stacked`.
    beta_0: MissedRule = field(default_factory=ProductOfViews)
