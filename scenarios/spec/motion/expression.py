"""Numbers of a script: plain, with a unit, or a sum of parameters such as `0.6*speed + 2 cm/s`."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated, Any

from pydantic import BeforeValidator, WithJsonSchema

from scenarios.spec.parameters.numeric import Numeric
from scenarios.spec.parameters.record import fault_at
from scenarios.spec.parameters.units import UNITS, parse_quantity
from scenarios.spec.value_text import describe_value
from sim.motion.stage import Values, number

MAX_TERMS = 8
_TERM = re.compile(r"(?:(\d+\.?\d*|\.\d+)\s*\*\s*)?([A-Za-z_]\w*)", re.ASCII)
_SUM = re.compile(r"\s*([+-]?)\s*([^+\-\s][^+-]*)", re.ASCII)


@dataclass(frozen=True)
class Expression:
    """constant + the sum of factor * parameter over terms, in a base unit."""

    constant: float
    terms: tuple[tuple[float, str], ...] = ()

    def value(self, values: Values) -> float:
        """Its value. values: of the parameters, in SI units."""
        return self.constant + sum(factor * number(values, name) for factor, name in self.terms)

    def ends(self, parameters: Mapping[str, Numeric]) -> tuple[float, float]:
        """Least and greatest value over the ranges of its parameters."""
        low = high = self.constant
        for factor, name in self.terms:
            scale = factor * UNITS[parameters[name].unit][1]
            both = sorted(scale * end for end in parameters[name].range)
            low, high = low + both[0], high + both[1]
        return low, high


@lru_cache(maxsize=4096)
def parse_expression(text: str, unit: str) -> Expression:
    """Read a number of a base unit. Raises ValueError with the rule that the text breaks."""
    try:
        return Expression(parse_quantity(text, unit))
    except ValueError as fault:
        if re.fullmatch(r"\s*[+-]?[\d.]+.*", text) and "*" not in text and " + " not in text:
            raise ValueError(f"{fault}") from None
    constant, end = 0.0, 0
    terms: list[tuple[float, str]] = []
    for match in _SUM.finditer(text):
        if match.start() != end or len(terms) > MAX_TERMS or (end and not match[1]):
            break
        sign, term = -1.0 if match[1] == "-" else 1.0, match[2].strip()
        named = _TERM.fullmatch(term)
        if named:
            terms.append((sign * float(named[1] or 1.0), named[2]))
        else:
            constant += sign * parse_quantity(term, unit)
        end = match.end()
    if end != len(text) or not text.strip() or len(terms) > MAX_TERMS:
        raise ValueError(
            f"must be a number in {unit}, or a sum of parameters such as `0.5*name + 0.1`, "
            f"got {text[:60]!r}"
        )
    return Expression(constant, tuple(terms))


def expression_of(value: float | str, unit: str) -> Expression:
    """The expression of a field that was read."""
    return parse_expression(value, unit) if isinstance(value, str) else Expression(float(value))


def quantity_type(unit: str, least: float, most: float, meaning: str = "") -> Any:
    """The type of a field that is a number of this base unit, or an expression of parameters."""

    def read(value: Any) -> float | str:
        if isinstance(value, bool) or not isinstance(value, int | float | str):
            kind = "a number" if unit == "1" else f"a number in {unit}"
            raise fault_at(f"must be {kind} or a parameter, got {describe_value(value)}")
        if isinstance(value, str):
            try:
                expression = parse_expression(value, unit)
            except ValueError as fault:
                raise fault_at(str(fault)) from None
            if expression.terms:
                return value.strip()
            value = expression.constant
        if not math.isfinite(value):
            raise fault_at(f"must be finite, got {value}")
        beyond = outside(float(value), float(value), unit, least, most)
        if beyond:
            raise fault_at(beyond)
        return float(value)

    described = f"{meaning} [{unit}], {least:g} to {most:g}".strip()
    schema = {"anyOf": [{"type": "number"}, {"type": "string"}], "description": described}
    return Annotated[float | str, BeforeValidator(read), WithJsonSchema(schema)]


def outside(low: float, high: float, unit: str, least: float, most: float) -> str:
    """The fault of a number that goes from low to high but must be from least to most, or ""."""
    if least - 1e-9 <= low and high <= most + 1e-9:
        return ""
    named = "" if unit == "1" else f" {unit}"
    got = f"{low:g}" if low == high else f"{low:g} to {high:g}"
    return f"must be from {least:g} to {most:g}{named}, got {got}"


def fault_of_expression(
    expression: Expression,
    unit: str,
    ends: tuple[float, float],
    parameters: Mapping[str, object],
    hint: Callable[[str], str],
) -> str:
    """The fault of an expression whose parameters are these, or "".

    ends: least and greatest value that the field takes; hint: what a misspelt name may have meant.
    """
    for _, name in expression.terms:
        parameter = parameters.get(name)
        if parameter is None:
            return f"no such parameter {name!r}{hint(name)}"
        if not isinstance(parameter, Numeric):
            return f"the parameter {name} is not a number"
        if UNITS[parameter.unit][0] != unit:
            kind = "without a unit" if unit == "1" else f"in {unit}"
            return f"must be {kind}, the parameter {name} is in {parameter.unit}"
    numbers = {n: p for n, p in parameters.items() if isinstance(p, Numeric)}
    fault = outside(*expression.ends(numbers), unit, *ends)
    return f"{fault} over the ranges of its parameters" if fault else ""
