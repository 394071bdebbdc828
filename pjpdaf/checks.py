"""Bounds of parameters, declared with a field's type; a value outside is one line that names it."""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable, Iterator
from dataclasses import dataclass
from functools import cache
from typing import Annotated, Any, cast, get_args, get_type_hints

from pjpdaf.errors import BenchError


class BadParameter(BenchError):
    """A parameter out of its range, or a KEY=VALUE that names none or does not fit."""


@dataclass(frozen=True)
class Bound:
    """The range of a finite number; rule: in words."""

    rule: str
    holds: Callable[[float], bool]


_ABOVE_ZERO = Bound("above 0", lambda value: value > 0)
_NOT_NEGATIVE = Bound("at least 0", lambda value: value >= 0)
_BETWEEN = Bound("between 0 and 1", lambda value: 0 < value < 1)

AboveZero = Annotated[float, _ABOVE_ZERO]
AboveZeroInt = Annotated[int, _ABOVE_ZERO]
NotNegative = Annotated[float, _NOT_NEGATIVE]
NotNegativeInt = Annotated[int, _NOT_NEGATIVE]
BetweenZeroAndOne = Annotated[float, _BETWEEN]


def check_bounds(owner: str, record: Any) -> None:
    """Raise BadParameter for the first field outside its bound; owner: as named there."""
    for name, bound in _bounds(cast(Hashable, type(record))):
        value = getattr(record, name)
        if not (math.isfinite(value) and bound.holds(value)):
            raise BadParameter(f"{owner}.{name} must be {bound.rule}, got {value!r}.")


@cache
def _bounds(record: Any) -> tuple[tuple[str, Bound], ...]:
    return tuple(_declared(record))


def _declared(record: type) -> Iterator[tuple[str, Bound]]:
    for name, hint in get_type_hints(record, include_extras=True).items():
        yield from ((name, note) for note in get_args(hint)[1:] if isinstance(note, Bound))
