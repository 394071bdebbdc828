"""Margins of the gate: how much worse each metric may be, from a YAML file."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated

from pydantic import Field

from pjpdaf.errors import BenchError
from reports.gate.metrics import with_margins
from scenarios.spec.loader import parse, read_text
from scenarios.spec.parameters.record import Name, Number, Record


class Margins(Record):
    """metric -> the greatest difference of the means that does not matter, in its unit."""

    margins: dict[Name, Annotated[Number, Field(ge=0)]]


def load_margins(path: Path) -> Mapping[str, float]:
    """The margins of a file such as `margins: {error_mm: 2.5, lost: 0.05}`.

    Raises BenchError with the place of the first fault.
    """
    text = read_text(path)
    try:
        margins = parse(text, str(path), Margins).margins
    except BenchError as fault:
        raise BenchError(f"{fault} (it is written as `margins: {{error_mm: 2.5}}`)") from None
    try:
        with_margins(margins)
    except BenchError as fault:
        raise BenchError(f"{path}: {fault}") from None
    return margins


def read_margins(pairs: tuple[str, ...]) -> Mapping[str, float]:
    """Read the values of `--margin METRIC=VALUE`. Raises BenchError."""
    margins: dict[str, float] = {}
    for pair in pairs:
        name, equals, value = pair.partition("=")
        try:
            number = float(value)
        except ValueError:
            raise BenchError(f"--margin {pair}: must be METRIC=VALUE, a number") from None
        if not equals or name in margins:
            raise BenchError(f"--margin {pair}: must be METRIC=VALUE, each metric once")
        margins[name] = number
        try:
            with_margins({name: number})
        except BenchError as fault:
            raise BenchError(f"--margin {pair}: {fault}") from None
    return margins
