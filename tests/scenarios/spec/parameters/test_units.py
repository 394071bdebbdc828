"""Quantities with units."""

from __future__ import annotations

import math

import pytest

from scenarios.spec.parameters.units import parse_quantity


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("0.3", "m/s", 0.3),
        ("0.3 m/s", "m/s", 0.3),
        ("0.3m/s", "m/s", 0.3),
        ("30 cm/s", "m/s", 0.3),
        ("3.6 km/h", "m/s", 1.0),
        (" 12 mm ", "m", 0.012),
        ("180 deg", "rad", math.pi),
        ("-1e-2 m", "cm", -1.0),
        ("7 1", "1", 7.0),
    ],
)
def test_quantities_carry_units(text, unit, value):
    assert parse_quantity(text, unit) == pytest.approx(value)


@pytest.mark.parametrize(
    "text", ["", "m", "1 2", "0.3 furlong", "--1", "1e", "0x10", "٣ m", "1e999"]
)
def test_what_is_no_quantity_is_refused(text):
    with pytest.raises(ValueError, match="must be"):
        parse_quantity(text, "m")
