"""The space that a search moves in: parameters of a family between the unit cube and their units.

Three coordinates of the same point: its *values* in physical units; a point u of the unit cube,
uniform over the ranges, for a search that must reach the corners; a standard-normal latent z, for
an estimate under the nominal distribution: value = F^-1(Phi(z)).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import ndtr

from pjpdaf.arrays import Floats
from pjpdaf.errors import BenchError
from scenarios.spec.draw import SETTINGS, setting_of
from scenarios.spec.parameters.choice import Choice
from scenarios.spec.parameters.distributions import LogUniform
from scenarios.spec.parameters.numeric import Numeric
from scenarios.stress.families import FPS, StressFamily
from sim.motion.stage import Value

PARTS = ("low", "middle", "high")  # thirds
DIGITS = 6  # significant, of every value: a case is short to write, and the same when read back


@dataclass(frozen=True)
class Axis:
    """A parameter that varies. low, high: the range that is searched, of a number."""

    name: str
    parameter: Numeric | Choice
    low: float = 0.0
    high: float = 1.0

    @property
    def choices(self) -> tuple[str, ...]:
        """Names to choose from; none for a number."""
        return self.parameter.choices if isinstance(self.parameter, Choice) else ()

    @property
    def logarithmic(self) -> bool:
        """Whether its search goes by the logarithm."""
        if not isinstance(self.parameter, Numeric) or self.low <= 0:
            return False
        return isinstance(self.parameter.nominal, LogUniform) or self.parameter is FPS

    def of_unit(self, u: float) -> Value:
        """The value at u of 0 to 1 of its range; choices split it evenly."""
        u = min(max(u, 0.0), 1.0)
        if self.choices:
            return self.choices[min(int(u * len(self.choices)), len(self.choices) - 1)]
        if self.logarithmic:
            return self.rounded(self.low * (self.high / self.low) ** u)
        return self.rounded(self.low + u * (self.high - self.low))

    def to_unit(self, value: Value) -> float:
        """The inverse of `of_unit`; of a choice, the middle of its part."""
        if self.choices:
            return (self.choices.index(str(value)) + 0.5) / len(self.choices)
        number = min(max(float(value), self.low), self.high)
        if self.low == self.high:
            return 0.5
        if self.logarithmic:
            return math.log(number / self.low) / math.log(self.high / self.low)
        return (number - self.low) / (self.high - self.low)

    def of_latent(self, z: float) -> Value:
        """The quantile of the nominal distribution at Phi(z)."""
        value = self.parameter.quantile(float(ndtr(z)))
        return value if isinstance(value, str) else self.rounded(value)

    def nominal(self) -> Value:
        """The median of a number; the likeliest choice, the first of several."""
        if isinstance(self.parameter, Choice):
            weights = self.parameter.weights or (1.0,) * len(self.choices)
            return self.choices[weights.index(max(weights))]
        return self.rounded(self.parameter.quantile(0.5))

    def rounded(self, value: float) -> float:
        """A number to `DIGITS` significant digits, inside the parameter's range."""
        assert isinstance(self.parameter, Numeric)
        least, most = self.parameter.range
        return min(max(float(f"{value:.{DIGITS}g}"), least), most)


@dataclass(frozen=True)
class Space:
    """The searched parameters of a family, in order; d of them. fixed: values that are set."""

    family: StressFamily
    axes: tuple[Axis, ...]
    fixed: Mapping[str, Value]

    @staticmethod
    def of(
        family: StressFamily,
        also: Sequence[str] = (),
        fixed: Mapping[str, Value] | None = None,
        ranges: Mapping[str, tuple[float, float]] | None = None,
    ) -> Space:
        """The space of a family.

        also: further parameters that vary, `fps` among them; fixed: parameters that do not, with
        their values; ranges: narrower ones. Raises BenchError for an unknown parameter, a value or
        a range that does not fit, a range of a choice.
        """
        fixed, ranges = dict(fixed or {}), dict(ranges or {})
        names = [name for name in dict.fromkeys((*family.searched, *also)) if name not in fixed]
        known = {*names, *fixed}
        for name in ranges:
            family.parameter(name)
            if name not in known:
                names.append(name)
        checked = {name: _checked(family, name, value) for name, value in fixed.items()}
        axes = tuple(_axis(family, name, ranges.get(name)) for name in names)
        return Space(family, axes, checked)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the parameters that vary."""
        return tuple(axis.name for axis in self.axes)

    def axis(self, name: str) -> Axis:
        """The axis of a parameter. Raises BenchError where it does not vary."""
        for axis in self.axes:
            if axis.name == name:
                return axis
        self.family.parameter(name)
        raise BenchError(f"{self.family.name}: {name} does not vary here")

    def values_of_unit(self, u: Sequence[float] | Floats) -> dict[str, Value]:
        """Values at a point (d,) of the unit cube."""
        return self._with_fixed({a.name: a.of_unit(float(x)) for a, x in self._paired(u)})

    def values_of_latent(self, z: Sequence[float] | Floats) -> dict[str, Value]:
        """Values at a latent point (d,): nominally distributed where z is standard normal."""
        return self._with_fixed({a.name: a.of_latent(float(x)) for a, x in self._paired(z)})

    def unit_of_values(self, values: Mapping[str, Value]) -> Floats:
        """The point (d,) of the unit cube of values; values out of range are moved to its end."""
        return np.array([axis.to_unit(values[axis.name]) for axis in self.axes])

    def nominal(self) -> dict[str, Value]:
        """Medians of the numbers, likeliest choices."""
        return self._with_fixed({axis.name: axis.nominal() for axis in self.axes})

    def _paired(self, point: Sequence[float] | Floats) -> list[tuple[Axis, float]]:
        return list(zip(self.axes, np.asarray(point, dtype=float).tolist(), strict=True))

    def _with_fixed(self, values: Mapping[str, Value]) -> dict[str, Value]:
        return {**values, **self.fixed}


def third(share: float) -> str:
    """The third in which a share (0-1) lies."""
    return PARTS[min(int(share * len(PARTS)), len(PARTS) - 1)]


def _axis(family: StressFamily, name: str, narrowed: tuple[float, float] | None) -> Axis:
    parameter = family.parameter(name)
    if isinstance(parameter, Choice):
        if narrowed is not None:
            listed = ", ".join(parameter.choices)
            raise BenchError(f"{name}: is one of {listed}; it has no range")
        return Axis(name, parameter)
    low, high = family.ranges.get(name, parameter.range)
    if narrowed is not None:
        low, high = narrowed
        least, most = parameter.range
        if low > high:
            raise BenchError(f"{name}: range is reversed: {low:g} is greater than {high:g}")
        if low < least or high > most:
            raise BenchError(
                f"{name}: {low:g} to {high:g} is outside its range {least:g} to {most:g} "
                f"{parameter.unit}"
            )
    return Axis(name, parameter, low, high)


def _checked(family: StressFamily, name: str, value: Value) -> Value:
    if name in SETTINGS:
        return setting_of(family.scenario, {name: value}, name)
    if name in family.scenario.parameters and not isinstance(value, int | float):
        # A file too: it is kept by its name, and read when the case is played.
        return family.scenario.parameters[name].check(name, value)
    return family.parameter(name).check(name, value)
