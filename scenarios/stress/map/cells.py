"""The cells of a map: an even grid at first, then quarters along the contour."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from pjpdaf.errors import BenchError
from reports.gate.statistics import wilson
from scenarios.stress.space import Axis

MOST_CELLS = 2500
MOST_RUNS = 200_000
Ends = tuple[float, float]


@dataclass(frozen=True)
class Cell:
    """A rectangle of the unit square; depth: how often it was halved."""

    x: Ends
    y: Ends
    depth: int = 0

    @property
    def centre(self) -> tuple[float, float]:
        """Where its trials are played."""
        return (self.x[0] + self.x[1]) / 2, (self.y[0] + self.y[1]) / 2

    @property
    def address(self) -> str:
        """Its random numbers' address: the same cell of another map has the same draws."""
        (x0, x1), (y0, y1) = self.x, self.y
        return f"{x0:.6f}-{x1:.6f}/{y0:.6f}-{y1:.6f}"


def grid(x: Axis, y: Axis | None, count: int) -> list[Cell]:
    """`count` cells along each axis, of a choice one for each. Raises BenchError for too many."""
    columns = _ends(len(x.choices) or count)
    rows = _ends(len(y.choices) or count) if y is not None else [(0.0, 1.0)]
    if len(columns) * len(rows) > MOST_CELLS:
        raise BenchError(
            f"a map of {len(columns)} x {len(rows)} cells is too many; at most {MOST_CELLS} cells"
        )
    return [Cell(column, row) for row in rows for column in columns]


def split(cell: Cell, x: Axis, y: Axis | None) -> list[Cell]:
    """The halves or quarters of a cell; the cell itself where both axes are choices."""
    columns = [cell.x] if x.choices else _halves(cell.x)
    rows = [cell.y] if y is None or y.choices else _halves(cell.y)
    if len(columns) * len(rows) == 1:
        return [cell]
    return [Cell(column, row, cell.depth + 1) for row in rows for column in columns]


def on_contour(
    cells: Sequence[Cell], tallies: Sequence[tuple[int, int]], level: float
) -> list[bool]:
    """Which cells, with (failures, n) each, the contour may cross.

    Those whose Wilson interval contains the level, and neighbours on either side of it.
    """
    intervals = [wilson(k, n) for k, n in tallies]
    sides = [(low > level) - (high < level) for low, high in intervals]
    return [
        side == 0 or any(sides[j] == -side and _touch(cell, other) for j, other in enumerate(cells))
        for cell, side in zip(cells, sides, strict=True)
    ]


def _touch(a: Cell, b: Cell) -> bool:
    """Whether two cells share a part of an edge."""
    across = min(a.x[1], b.x[1]) - max(a.x[0], b.x[0])
    along = min(a.y[1], b.y[1]) - max(a.y[0], b.y[0])
    return max(across, along) > 1e-9 and min(across, along) > -1e-9


def _ends(count: int) -> list[Ends]:
    return [(i / count, (i + 1) / count) for i in range(count)]


def _halves(ends: Ends) -> list[Ends]:
    middle = (ends[0] + ends[1]) / 2
    return [(ends[0], middle), (middle, ends[1])]
