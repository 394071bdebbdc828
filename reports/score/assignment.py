"""Pairs of the least total cost, for a handful of rows and columns.

Shortest augmenting paths (Crouse 2016), in the order of `scipy.optimize.linear_sum_assignment`, so
that of equally cheap choices it takes the same: that function's package is most of SciPy, which
every worker would load for matrices of three rows.
"""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Ints

Row = list[float]


def assignment(cost: NDArray[Any]) -> tuple[Ints, Ints]:
    """Rows, ascending, and columns of the min(n, m) pairs of a finite cost (n, m)."""
    rows, columns = cost.shape
    if rows > columns:
        of_column, of_row = assignment(cost.T)
        order = np.argsort(of_row)
        return of_row[order], of_column[order]
    costs: list[Row] = cost.tolist()
    if not all(map(math.isfinite, itertools.chain.from_iterable(costs))):
        raise ValueError("costs must be finite")
    return np.arange(rows), np.array(_columns(costs, columns), np.intp)


def _columns(cost: list[Row], width: int) -> list[int]:
    """The column of each row."""
    row_price, column_price = [0.0] * len(cost), [0.0] * width
    column_of, row_of = [-1] * len(cost), [-1] * width
    backwards = range(width - 1, -1, -1)
    for new, of_new in enumerate(cost):
        # Mostly the cheapest column is free.
        best, lowest = -1, math.inf
        for column in backwards:
            way = of_new[column] - column_price[column]
            if way < lowest or (way == lowest and row_of[column] == -1):
                best, lowest = column, way
        if row_of[best] == -1:
            column_of[new], row_of[best], row_price[new] = best, new, lowest
            continue
        free, total, path, shortest, seen = _path(cost, new, row_price, column_price, row_of)
        row_price[new] = total
        for row in {row_of[column] for column in seen} - {-1}:
            row_price[row] += total - shortest[column_of[row]]
        for column in seen:
            column_price[column] -= total - shortest[column]
        column = free
        while True:
            row = row_of[column] = path[column]
            column_of[row], column = column, column_of[row]
            if row == new:
                break
    return column_of


def _path(
    cost: list[Row], row: int, row_price: Row, column_price: Row, row_of: list[int]
) -> tuple[int, float, list[int], Row, list[int]]:
    """The cheapest way from a row to a free column, by columns that are taken.

    Returns that column, the way's cost, each column's row on the way to it, its cost, and the
    columns passed.
    """
    width = len(row_of)
    total, path, shortest = 0.0, [-1] * width, [math.inf] * width
    seen: list[int] = []
    left = [*range(width - 1, -1, -1)]
    while True:
        best, lowest = -1, math.inf
        for i, column in enumerate(left):
            way = total + cost[row][column] - row_price[row] - column_price[column]
            if way < shortest[column]:
                path[column], shortest[column] = row, way
            # Of equals rather a free one, where the way ends.
            if shortest[column] < lowest or (shortest[column] == lowest and row_of[column] == -1):
                best, lowest = i, shortest[column]
        total, column = lowest, left[best]
        seen.append(column)
        if row_of[column] == -1:
            return column, total, path, shortest, seen
        row = row_of[column]
        left[best] = left[-1]
        left.pop()
