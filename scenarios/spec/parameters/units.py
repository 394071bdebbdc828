"""Units of parameters, and text such as "0.3 m/s" or "30 cm" read in them."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from typing import Literal

# Unit -> (base unit, factor). A parameter is kept in its own unit; text may use any of its kind.
UNITS: Mapping[str, tuple[str, float]] = {
    "m": ("m", 1.0),
    "cm": ("m", 0.01),
    "mm": ("m", 0.001),
    "m/s": ("m/s", 1.0),
    "cm/s": ("m/s", 0.01),
    "mm/s": ("m/s", 0.001),
    "km/h": ("m/s", 1 / 3.6),
    "s": ("s", 1.0),
    "ms": ("s", 0.001),
    "rad": ("rad", 1.0),
    "deg": ("rad", math.pi / 180.0),
    "px": ("px", 1.0),
    "grey": ("grey", 1.0),
    "Hz": ("Hz", 1.0),
    "K": ("K", 1.0),
    "EV": ("EV", 1.0),
    "1": ("1", 1.0),
    "%": ("1", 0.01),
}
Unit = Literal[
    "m", "cm", "mm", "m/s", "cm/s", "mm/s", "km/h", "s", "ms", "rad", "deg", "px", "grey",
    "Hz", "K", "EV", "1", "%",
]  # fmt: skip
_QUANTITY = re.compile(
    r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d{1,3})?)\s*([^\s\d.+-]\S*|1)?\s*", re.ASCII
)


def parse_quantity(text: str, unit: str) -> float:
    """Read a number, with or without a unit of the same kind, in `unit`. Raises ValueError."""
    match = _QUANTITY.fullmatch(text)
    if match is None:
        raise ValueError(f"must be a number in {unit}, got {text[:60]!r}")
    value, given = float(match[1]), match[2]
    if not math.isfinite(value):
        raise ValueError(f"must be finite, got {text[:60]!r}")
    if given is None:
        return value
    base, factor = UNITS[unit]
    if given not in UNITS or UNITS[given][0] != base:
        fit = ", ".join(name for name, (kind, _) in UNITS.items() if kind == base)
        raise ValueError(f"must be in {fit}, got unit {given[:20]!r}")
    # 0.3 m/s stays 0.3: no factor where there is nothing to convert.
    return value if given == unit else value * UNITS[given][1] / factor
