"""A parameter that is one of several names."""

from __future__ import annotations

from typing import Annotated, Self

from pydantic import Field, model_validator

from pjpdaf.errors import BenchError
from scenarios.spec.parameters.record import Name, Number, Record, Text, fault_at
from scenarios.spec.suggestion import did_you_mean
from sim.motion.stage import Value


class Choice(Record):
    """A choice among named options, equally likely or by weight."""

    choices: Annotated[tuple[Name, ...], Field(min_length=1)]
    weights: tuple[Annotated[Number, Field(ge=0)], ...] | None = None
    meaning: Text = ""

    @model_validator(mode="after")
    def _weights_fit(self) -> Self:
        if self.weights is not None:
            if len(self.weights) != len(self.choices):
                raise fault_at(
                    f"{len(self.weights)} weights for {len(self.choices)} choices", "weights"
                )
            if sum(self.weights) <= 0:
                raise fault_at("at least one weight must be above 0", "weights")
        return self

    def quantile(self, share: float) -> str:
        """The choice at this share (0-1) of the cumulated weights."""
        weights = self.weights or (1.0,) * len(self.choices)
        left = share * sum(weights)
        for choice, weight in zip(self.choices, weights, strict=True):
            left -= weight
            if left < 0:
                return choice
        return [c for c, w in zip(self.choices, weights, strict=True) if w > 0][-1]

    def check(self, name: str, value: Value) -> str:
        """A value set by hand. Raises BenchError naming the choices."""
        if value not in self.choices:
            known = ", ".join(self.choices)
            hint = did_you_mean(str(value), self.choices)
            raise BenchError(f"{name}: must be one of {known}, got {str(value)[:60]!r}{hint}")
        return str(value)
