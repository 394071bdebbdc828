"""A parameter that is a number, kept in its physical unit."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Self

from pydantic import field_validator, model_validator
from scipy.special import ndtri

from pjpdaf.errors import BenchError
from scenarios.spec.parameters.distributions import Distribution, Fixed, LogUniform, Uniform
from scenarios.spec.parameters.record import Number, Record, Text, fault_at
from scenarios.spec.parameters.units import UNITS, Unit, parse_quantity
from sim.motion.stage import Value


class Numeric(Record):
    """A number: unit, range [least, greatest], and nominal distribution."""

    unit: Unit
    range: tuple[Number, Number]
    nominal: Distribution
    meaning: Text = ""

    @model_validator(mode="before")
    @classmethod
    def _with_units(cls, data: Any) -> Any:
        """Text such as "0.3 m/s" or "30 cm" becomes the number in this parameter's unit."""
        unit = data.get("unit") if isinstance(data, Mapping) else None
        if not isinstance(unit, str) or unit not in UNITS:
            return data

        def plain(value: Any, place: str) -> Any:
            if not isinstance(value, str):
                return value
            try:
                return parse_quantity(value, unit)
            except ValueError as fault:
                raise fault_at(str(fault), place) from None

        read = dict(data)
        if isinstance(read.get("range"), list | tuple):
            read["range"] = [plain(v, f"range.{i}") for i, v in enumerate(read["range"])]
        if isinstance(read.get("nominal"), Mapping):
            read["nominal"] = {
                key: plain(v, f"nominal.{key}") if key != "kind" else v
                for key, v in read["nominal"].items()
            }
        return read

    @field_validator("range")
    @classmethod
    def _forward(cls, ends: tuple[float, float]) -> tuple[float, float]:
        if ends[0] > ends[1]:
            raise fault_at(f"range is reversed: {ends[0]:g} is greater than {ends[1]:g}")
        return ends

    @model_validator(mode="after")
    def _nominal_inside(self) -> Self:
        low, high = self.range
        for key, value in self.nominal.model_dump(exclude={"kind", "sd"}).items():
            if value is not None and not low <= value <= high:
                raise fault_at(
                    f"{value:g} is outside the range {low:g} to {high:g} {self.unit}",
                    f"nominal.{key}",
                )
        if isinstance(self.nominal, Uniform | LogUniform):
            a, b = self.bounds
            if a > b:
                raise fault_at(f"low {a:g} is greater than high {b:g}", "nominal.low")
            if isinstance(self.nominal, LogUniform) and a <= 0:
                raise fault_at(f"log-uniform needs a low end above 0, got {a:g}", "nominal")
        return self

    @property
    def bounds(self) -> tuple[float, float]:
        """Ends of the nominal distribution: its own where it has any, else the range."""
        low, high = self.range
        if isinstance(self.nominal, Uniform | LogUniform):
            low = low if self.nominal.low is None else self.nominal.low
            high = high if self.nominal.high is None else self.nominal.high
        return low, high

    def quantile(self, share: float) -> float:
        """The value below which this share (0-1) of the nominal distribution lies: F^-1(share)."""
        return self.nominal.quantile(share, *self.bounds)

    def cdf(self, value: float) -> float:
        """F(value) of the nominal distribution, the inverse of `quantile` (1/2 where fixed)."""
        low, high = self.bounds
        if isinstance(self.nominal, Fixed) or low == high:
            return 0.5
        return min(max(self.nominal.cdf(value, low, high), 0.0), 1.0)

    def latent(self, value: float) -> float:
        """The standard-normal number z of a value: Phi^-1(F(value)), for searches."""
        return float(ndtri(self.cdf(value)))

    def check(self, name: str, value: Value) -> float:
        """A value set by hand: a number or text with a unit. Raises BenchError naming the range."""
        low, high = self.range
        try:
            number = parse_quantity(value, self.unit) if isinstance(value, str) else float(value)
        except ValueError as fault:
            raise BenchError(f"{name}: {fault} (range {low:g} to {high:g} {self.unit})") from None
        if not low <= number <= high:
            ends = f"{low:g} to {high:g} {self.unit}"
            raise BenchError(f"{name}: {number:g} {self.unit} is outside its range {ends}")
        return number
