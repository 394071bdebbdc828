"""Any parameter of a scenario, and short ways to declare the standard ones."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import Discriminator, Tag

from scenarios.spec.parameters.choice import Choice
from scenarios.spec.parameters.distributions import Fixed, Normal, Uniform
from scenarios.spec.parameters.file import File
from scenarios.spec.parameters.numeric import Numeric
from scenarios.spec.parameters.units import Unit


def _tag_of(data: Any) -> str:
    if isinstance(data, File) or (isinstance(data, Mapping) and "file" in data):
        return "from a file"  # not a possible field name: locations of faults carry the tag
    if isinstance(data, Choice) or (isinstance(data, Mapping) and "choices" in data):
        return "choice"
    return "numeric"


Parameter = Annotated[
    Annotated[Numeric, Tag("numeric")]
    | Annotated[Choice, Tag("choice")]
    | Annotated[File, Tag("from a file")],
    Discriminator(_tag_of),
]


def fixed(unit: Unit, low: float, high: float, value: float, meaning: str) -> Numeric:
    """A number that stays at `value` unless it is set within [low, high]."""
    nominal = Fixed(kind="fixed", value=value)
    return Numeric(unit=unit, range=(low, high), nominal=nominal, meaning=meaning)


def normal(unit: Unit, low: float, high: float, mean: float, sd: float, meaning: str) -> Numeric:
    """A number that is nominally normal, cut to [low, high]."""
    nominal = Normal(kind="normal", mean=mean, sd=sd)
    return Numeric(unit=unit, range=(low, high), nominal=nominal, meaning=meaning)


def uniform(unit: Unit, ends: tuple[float, float], a: float, b: float, meaning: str) -> Numeric:
    """A number that is nominally equally likely from a to b, within the range `ends`."""
    nominal = Uniform(kind="uniform", low=a, high=b)
    return Numeric(unit=unit, range=ends, nominal=nominal, meaning=meaning)


def choice(weights: Mapping[str, float], meaning: str) -> Choice:
    """One of the names, each as likely as its weight."""
    return Choice(choices=tuple(weights), weights=tuple(weights.values()), meaning=meaning)
