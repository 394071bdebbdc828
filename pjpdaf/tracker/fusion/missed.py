"""Readings of beta_0 of all views together (Eq. 3.42)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol, final

import numpy as np

from pjpdaf.arrays import Bools, Floats


class MissedRule(Protocol):
    """Weight of "not detected" over all views."""

    def __call__(self, beta_0: Floats, present: Bools, used: Bools) -> Floats:
        """beta_0 (T,) from each view's beta_0, present and used, all (T, N)."""
        ...


@final
@dataclass(frozen=True)
class SumOfViews:
    """The sum, as printed; it may exceed 1."""

    def __call__(self, beta_0: Floats, present: Bools, used: Bools) -> Floats:
        """Return the sum over the views whose picture is there."""
        return np.asarray(np.where(present, beta_0, 0.0).sum(axis=1))


@final
@dataclass(frozen=True)
class ProductOfViews:
    """The product: not detected in any view, as the text around Eq. 3.42 has it."""

    def __call__(self, beta_0: Floats, present: Bools, used: Bools) -> Floats:
        """Return the product over the views that take part."""
        return np.asarray(np.where(used, beta_0, 1.0).prod(axis=1))


MISSED_RULES: Mapping[str, MissedRule] = {"sum": SumOfViews(), "product": ProductOfViews()}
