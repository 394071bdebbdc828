"""Nominal distributions of a number, each cut to the range [low, high] of its parameter.

`quantile` and `cdf` are inverse to each other: F^-1(share) and F(value).
"""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import Field
from scipy.special import ndtr, ndtri

from scenarios.spec.parameters.record import Number, Record


class Uniform(Record):
    """Equally likely from low to high (left out: the parameter's range)."""

    kind: Literal["uniform"]
    low: Number | None = None
    high: Number | None = None

    def quantile(self, share: float, low: float, high: float) -> float:
        """The value below which this share (0-1) lies."""
        return low + share * (high - low)

    def cdf(self, value: float, low: float, high: float) -> float:
        """The share (0-1) below this value."""
        return (value - low) / (high - low)


class LogUniform(Record):
    """The logarithm equally likely from low to high (left out: the parameter's range)."""

    kind: Literal["log-uniform"]
    low: Number | None = None
    high: Number | None = None

    def quantile(self, share: float, low: float, high: float) -> float:
        """The value below which this share (0-1) lies."""
        return float(min(max(low * (high / low) ** share, low), high))

    def cdf(self, value: float, low: float, high: float) -> float:
        """The share (0-1) below this value."""
        return math.log(value / low) / math.log(high / low)


class Normal(Record):
    """A normal distribution cut to the parameter's range."""

    kind: Literal["normal"]
    mean: Number
    sd: Annotated[Number, Field(gt=0)]

    def quantile(self, share: float, low: float, high: float) -> float:
        """The value below which this share (0-1) lies."""
        first, last = self._uncut(low), self._uncut(high)
        value = self.mean + self.sd * float(ndtri(first + share * (last - first)))
        return min(max(value, low), high)

    def cdf(self, value: float, low: float, high: float) -> float:
        """The share (0-1) below this value."""
        first, last = self._uncut(low), self._uncut(high)
        return (self._uncut(value) - first) / (last - first)

    def _uncut(self, value: float) -> float:
        return float(ndtr((value - self.mean) / self.sd))


class Fixed(Record):
    """Always this value; the range says how far it may be set."""

    kind: Literal["fixed"]
    value: Number

    def quantile(self, share: float, low: float, high: float) -> float:
        """The value, whatever the share."""
        return self.value

    def cdf(self, value: float, low: float, high: float) -> float:
        """1/2: nothing is below or above."""
        return 0.5


Distribution = Annotated[Uniform | LogUniform | Normal | Fixed, Field(discriminator="kind")]
