"""Cells of files of tracks or detections: frame numbers and finite numbers."""

from __future__ import annotations

import math
from typing import Any

from pjpdaf.errors import BenchError

LARGEST = 1e6


def read_frame(where: str, cell: Any, frames: int | None) -> int:
    """Read the index of a frame, below `frames` where their number is known. Raises BenchError."""
    number = read_number(where, "frame", cell)
    if number is None or not number.is_integer():
        raise BenchError(f"{where}: frame must be a whole number, got {str(cell)[:40]!r}")
    if number < 0 or (frames is not None and number >= frames):
        known = "" if frames is None else f": its {frames} frames count from 0 to {frames - 1}"
        raise BenchError(f"{where}: frame {number:.0f} is not in the sequence{known}")
    return int(number)


def read_number(where: str, name: str, cell: Any, unit: str = "") -> float | None:
    """Read a finite number; None for an empty cell. unit: named where the number is too large.

    Raises BenchError.
    """
    if cell is None or cell == "":
        return None
    try:
        if isinstance(cell, bool) or (isinstance(cell, str) and "_" in cell):
            raise ValueError
        value = float(cell)
    except (TypeError, ValueError, OverflowError):
        raise BenchError(f"{where}: {name} must be a number, got {str(cell)[:40]!r}") from None
    if not math.isfinite(value):
        raise BenchError(
            f"{where}: {name} is {cell}; where there is no estimate, leave the row out, or its "
            "cells empty"
        )
    if abs(value) > LARGEST:
        raise BenchError(f"{where}: {name} is {value:g}: {unit or 'a smaller number'} expected")
    return value
