"""A map of two parameters seen along one: failures over speed, whatever the frame rate."""

from __future__ import annotations

from typing import Literal

from reports.score.robustness import GOALS
from reports.stress.records import CellRecord, MapRecord

Along = Literal["x", "y"]


def marginal(record: MapRecord, along: Along) -> MapRecord:
    """The map over one of its two axes, the other pooled: each part of it counts alike.

    A cell that was split has more trials for its area: its trials count by area, and n is the
    number of equal ones that would say as much, (sum of a)^2 / sum of a^2 / n.
    """
    axis = record.x if along == "x" else record.y
    assert axis is not None
    count = round(1.0 / max(_width(cell, along) for cell in record.cells))
    columns = []
    for number in range(count):
        inside = [c for c in record.cells if int(_middle(c, along) * count) == number and c.n]
        if inside:
            columns.append(_pooled(inside, (number / count, (number + 1) / count), record))
    return record.model_copy(update={"x": axis, "y": None, "cells": tuple(columns), "occluded": ()})


def _pooled(cells: list[CellRecord], ends: tuple[float, float], record: MapRecord) -> CellRecord:
    areas = [_width(cell, "x") * _width(cell, "y") for cell in cells]
    n = round(sum(areas) ** 2 / sum(a * a / c.n for a, c in zip(areas, cells, strict=True)))
    failures = {}
    for goal in GOALS:
        shares = [c.failures.get(goal, 0) / c.n for c in cells]
        share = sum(a * p for a, p in zip(areas, shares, strict=True)) / sum(areas)
        failures[goal] = round(share * n)
    failing = (c for c in cells if c.failures.get(record.goal, 0) and c.episode)
    shown = next(failing, cells[0])
    return shown.model_copy(update={"x": ends, "y": (0.0, 1.0), "n": n, "failures": failures})


def _width(cell: CellRecord, along: Along) -> float:
    low, high = getattr(cell, along)
    return float(high - low)


def _middle(cell: CellRecord, along: Along) -> float:
    low, high = getattr(cell, along)
    return float(low + high) / 2
