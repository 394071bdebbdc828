"""Checks of parameter records: numbers within their range, or one line that names the field."""

from __future__ import annotations

import math
from typing import Any

from pjpdaf.errors import BenchError


class BadParameter(BenchError):
    """A parameter out of its range, or a KEY=VALUE that names none or does not fit."""


def check_above_zero(owner: str, record: Any, *names: str) -> None:
    """Raise BadParameter where a field is not a finite number above 0; owner: as named there."""
    for name in names:
        value = getattr(record, name)
        if not (math.isfinite(value) and value > 0):
            raise BadParameter(f"{owner}.{name} must be above 0, got {value!r}.")


def check_not_negative(owner: str, record: Any, *names: str) -> None:
    """Raise BadParameter where a field is not a finite number of at least 0."""
    for name in names:
        value = getattr(record, name)
        if not (math.isfinite(value) and value >= 0):
            raise BadParameter(f"{owner}.{name} must be at least 0, got {value!r}.")


def check_between_0_and_1(owner: str, record: Any, *names: str) -> None:
    """Raise BadParameter where a field is not between 0 and 1, both excluded."""
    for name in names:
        value = getattr(record, name)
        if not 0 < value < 1:
            raise BadParameter(f"{owner}.{name} must be between 0 and 1, got {value!r}.")
