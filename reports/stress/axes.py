"""The axes of maps and curves: shares of a parameter's range to pixels, with ticks."""

from __future__ import annotations

import math
from dataclasses import dataclass

from reports.page.charts.svg import round_step
from reports.stress.records import AxisRecord
from reports.stress.words import value_text


@dataclass(frozen=True)
class DrawnAxis:
    """A parameter's axis from pixel `start` (share 0) to `end` (share 1)."""

    record: AxisRecord
    start: float
    end: float

    def at(self, share: float) -> float:
        """The pixel of a share of the axis."""
        return self.start + share * (self.end - self.start)

    def value(self, share: float) -> float | str:
        """The parameter at a share of the axis."""
        axis = self.record
        if axis.choices:
            return axis.choices[min(int(share * len(axis.choices)), len(axis.choices) - 1)]
        if axis.log:
            return float(axis.low * (axis.high / axis.low) ** share)
        return axis.low + share * (axis.high - axis.low)

    def text(self, share: float) -> str:
        """The value at a share, with its unit."""
        return value_text(self.value(share), self.record.unit)

    @property
    def title(self) -> str:
        """Name and unit."""
        unit = self.record.unit
        name = self.record.name.replace("_", " ")
        return f"{name} [{unit}]" if unit not in ("1", "") else name

    def ticks(self) -> list[tuple[float, str]]:
        """(pixel, text) of round values, of a choice one for each."""
        axis = self.record
        if axis.choices:
            n = len(axis.choices)
            return [(self.at((i + 0.5) / n), c) for i, c in enumerate(axis.choices)]
        return [(self.at(self._share(v)), f"{v:g}") for v in self._round_values()]

    def _share(self, value: float) -> float:
        axis = self.record
        if axis.high == axis.low:
            return 0.5
        if axis.log:
            return math.log(value / axis.low) / math.log(axis.high / axis.low)
        return (value - axis.low) / (axis.high - axis.low)

    def _round_values(self) -> list[float]:
        low, high = self.record.low, self.record.high
        if high == low:
            return [low]
        if self.record.log:
            tens = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
            values = [f * 10.0**k for k in tens for f in (1, 2, 3, 5, 7)]
            inside = [float(f"{v:.6g}") for v in values if low <= v * 1.0001 and v <= high * 1.0001]
            return inside if len(inside) <= 8 else inside[::2]
        step = round_step((high - low) / 5)
        first, last = math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)
        return [round(i * step, 10) for i in range(first, last + 1)]
