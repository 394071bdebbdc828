"""Cubic splines: twice differentiable ones, and monotone ones.

The arithmetic, operation by operation, is that of `scipy.interpolate.CubicSpline` and
`PchipInterpolator`, so that the values are the same to the last bit. Every worker would load
SciPy's, and with it most of SciPy: a quarter of the CPU time of its start.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal

import numpy as np

from pjpdaf.arrays import Floats

Ends = Literal["natural", "not-a-knot", "periodic"] | tuple[float, float]


@dataclass(frozen=True, eq=False)
class Spline:
    """A piecewise polynomial.

    x (n,): its knots, ascending; c (k, n - 1, ...): coefficients of each piece, of the highest
    power of x - x[i] first; periodic: it goes on as it began, else as its first and last piece.
    """

    x: Floats
    c: Floats
    periodic: bool = False

    # Plain lists for one parameter, for which numpy takes long; many splines have no such calls.
    @cached_property
    def _knots(self) -> list[float]:
        """`x`."""
        knots: list[float] = self.x.tolist()
        return knots

    @cached_property
    def _pieces(self) -> list[list[list[float]]]:
        """`c` by piece and value."""
        pieces: list[list[list[float]]] = (
            self.c.reshape(*self.c.shape[:2], -1).transpose(1, 2, 0).tolist()
        )
        return pieces

    def __call__(self, at: float | Floats, derivative: int = 0) -> Floats:
        """Values (..., *) at parameters of any shape, or those of a derivative."""
        if isinstance(at, float):
            return self._at(at, derivative)
        all_at: Floats = np.asarray(at, np.float64)
        if self.periodic:
            all_at = self.x[0] + (all_at - self.x[0]) % (self.x[-1] - self.x[0])
        piece = np.clip(self.x.searchsorted(all_at, "right") - 1, 0, len(self.x) - 2)
        along = (all_at - self.x[piece]).reshape(all_at.shape + (1,) * (self.c.ndim - 2))
        return np.asarray(_polynomial(self.c[:, piece], along, derivative))

    def _at(self, at: float, derivative: int) -> Floats:
        """Value (*) at one parameter."""
        knots = self._knots
        if self.periodic:
            at = knots[0] + (at - knots[0]) % (knots[-1] - knots[0])
        piece = min(max(bisect_right(knots, at) - 1, 0), len(knots) - 2)
        along = at - knots[piece]
        values = [_polynomial(column, along, derivative) for column in self._pieces[piece]]
        return np.array(values).reshape(self.c.shape[2:])

    def antiderivative(self) -> Spline:
        """The integral from the first knot on; past the knots it is not periodic."""
        rising = np.arange(len(self.c), 0, -1.0).reshape(-1, *(1,) * (self.c.ndim - 1))
        c = np.concatenate([self.c / rising, np.zeros((1, *self.c.shape[1:]))])
        columns = c.reshape(*c.shape[:2], -1)
        for column in range(columns.shape[2]):
            pieces, end = columns[:, :, column].T.tolist(), 0.0
            for i, width in enumerate(np.diff(self.x).tolist()):
                pieces[i][-1] = end
                end = _polynomial(pieces[i], width)
            columns[-1, :, column] = [piece[-1] for piece in pieces]
        return Spline(self.x, c)


def _polynomial(c: Any, along: Any, derivative: int = 0) -> Any:
    """A polynomial or a derivative of it, by coefficients of the highest power first."""
    value, power = 0.0, 1.0
    for k in range(derivative, len(c)):
        value = value + c[-1 - k] * power * math.perm(k, derivative)
        power = power * along
    return value


def cubic(x: Floats, y: Floats, ends: Ends) -> Spline:
    """The twice differentiable cubic spline through y (n, ...) at x (n,).

    ends: natural, without curvature; not-a-knot, the first two pieces are one polynomial, and the
    last two (four knots or more); periodic; or the first derivatives there.
    """
    x, y = np.asarray(x, np.float64), np.asarray(y, np.float64)
    dx = np.diff(x)
    h = dx.reshape(-1, *(1,) * (y.ndim - 1))
    slope = np.diff(y, axis=0) / h
    if ends == "periodic":
        return _hermite(x, y, _periodic(dx, h, slope), periodic=True)
    lower, diagonal, upper, b = _inner(dx, h, slope)
    if ends == "natural":
        diagonal[0], upper[0], b[0] = 2 * dx[0], dx[0], 3 * (y[1] - y[0])
        diagonal[-1], lower[-1], b[-1] = 2 * dx[-1], dx[-1], 3 * (y[-1] - y[-2])
    elif ends == "not-a-knot":
        d = x[2] - x[0]
        diagonal[0], upper[0] = dx[1], d
        b[0] = ((h[0] + 2 * d) * h[1] * slope[0] + h[0] ** 2 * slope[1]) / d
        d = x[-1] - x[-3]
        diagonal[-1], lower[-1] = dx[-2], d
        b[-1] = (h[-1] ** 2 * slope[-2] + (2 * d + h[-1]) * h[-2] * slope[-1]) / d
    else:
        diagonal[0], upper[0], b[0] = 1.0, 0.0, ends[0]
        diagonal[-1], lower[-1], b[-1] = 1.0, 0.0, ends[1]
    return _hermite(x, y, solve_tridiagonal(lower, diagonal, upper, b))


def monotone(x: Floats, y: Floats) -> Spline:
    """The cubic spline through y (n, ...) at x (n,) that is monotone wherever y is.

    Fritsch and Butland 1984: harmonic means of the slopes, none at a turn.
    """
    x, y = np.asarray(x, np.float64), np.asarray(y, np.float64)
    h = np.diff(x).reshape(-1, *(1,) * (y.ndim - 1))
    slope = np.diff(y, axis=0) / h
    if len(x) == 2:
        return _hermite(x, y, np.concatenate([slope, slope]))
    sign = np.sign(slope)
    turn = (sign[1:] != sign[:-1]) | (slope[1:] == 0) | (slope[:-1] == 0)
    after, before = 2 * h[1:] + h[:-1], h[1:] + 2 * h[:-1]
    with np.errstate(divide="ignore", invalid="ignore"):
        mean = 1.0 / ((after / slope[:-1] + before / slope[1:]) / (after + before))
    ends = (
        _end_slope(h[0], h[1], slope[0], slope[1]),
        _end_slope(h[-1], h[-2], slope[-1], slope[-2]),
    )
    inner = np.where(turn, 0.0, mean)
    return _hermite(x, y, np.concatenate([ends[0][None], inner, ends[1][None]]))


def solve_tridiagonal(lower: Floats, diagonal: Floats, upper: Floats, b: Floats) -> Floats:
    """Solve A s = b for s (n, ...), by elimination with pivots as LAPACK's dgtsv.

    lower (n,): of each row, the first is not used; diagonal (n,); upper (n,): the last is not used.
    """
    n = len(diagonal)
    below, d, above = lower[1:].tolist(), diagonal.tolist(), upper[:-1].tolist()
    second = [0.0] * n  # of rows that are swapped with the next, two right of the diagonal
    factors, swapped = [0.0] * n, [False] * n
    for i in range(n - 1):
        if abs(d[i]) >= abs(below[i]):
            factors[i] = factor = below[i] / d[i]
            d[i + 1] = d[i + 1] - factor * above[i]
            continue
        swapped[i], factors[i] = True, d[i] / below[i]
        d[i], d[i + 1], above[i] = below[i], above[i] - factors[i] * d[i + 1], d[i + 1]
        if i < n - 2:
            second[i], above[i + 1] = above[i + 1], -factors[i] * above[i + 1]
    solved = np.empty((n, b[0].size))
    for column, s in enumerate(b.reshape(n, -1).T.tolist()):
        for i in range(n - 1):
            if swapped[i]:
                s[i], s[i + 1] = s[i + 1], s[i]
            s[i + 1] = s[i + 1] - factors[i] * s[i]
        s[-1] = s[-1] / d[-1]
        if n > 1:
            s[-2] = (s[-2] - above[-1] * s[-1]) / d[-2]
        for i in range(n - 3, -1, -1):
            s[i] = (s[i] - above[i] * s[i + 1] - second[i] * s[i + 2]) / d[i]
        solved[:, column] = s
    return solved.reshape(b.shape)


def _inner(dx: Floats, h: Floats, slope: Floats) -> tuple[Floats, Floats, Floats, Floats]:
    """Lower, diagonal, upper and right side of the equations of the slopes at all inner knots."""
    n = len(dx) + 1
    lower, diagonal, upper = np.zeros(n), np.zeros(n), np.zeros(n)
    b = np.zeros((n, *slope.shape[1:]))
    lower[1:-1], diagonal[1:-1], upper[1:-1] = dx[1:], 2 * (dx[:-1] + dx[1:]), dx[:-1]
    b[1:-1] = 3 * (h[1:] * slope[:-1] + h[:-1] * slope[1:])
    return lower, diagonal, upper, b


def _periodic(dx: Floats, h: Floats, slope: Floats) -> Floats:
    """Slopes (n, ...) at the knots of a periodic spline, of which the last is the first."""
    if len(dx) == 2:
        mean = (slope / h).sum(0) / (1.0 / h).sum(0)
        return np.broadcast_to(mean, (3, *slope.shape[1:]))
    lower, diagonal, upper, b = (part[:-1] for part in _inner(dx, h, slope))
    diagonal[0], upper[0] = 2 * (dx[-1] + dx[0]), dx[-1]
    b[0] = 3 * (h[0] * slope[-1] + h[-1] * slope[0])
    b[-1] = 3 * (h[-1] * slope[-2] + h[-2] * slope[-1])
    # The last unknown apart: what is left is tridiagonal.
    share = np.zeros_like(b[:-1])
    share[0], share[-1] = -dx[0], -dx[-3]
    matrix = lower[:-1], diagonal[:-1], upper[:-1]
    one, two = solve_tridiagonal(*matrix, b[:-1]), solve_tridiagonal(*matrix, share)
    last = (b[-1] - dx[-2] * one[0] - dx[-1] * one[-1]) / (
        2 * (dx[-1] + dx[-2]) + dx[-2] * two[0] + dx[-1] * two[-1]
    )
    inner = one + last * two
    return np.concatenate([inner, last[None], inner[:1]])


def _end_slope(h0: Floats, h1: Floats, slope0: Floats, slope1: Floats) -> Floats:
    """The slope at an end, by three points: monotone as these are (Moler 2004, 3.6)."""
    slope = ((2 * h0 + h1) * slope0 - h0 * slope1) / (h0 + h1)
    wrong = np.sign(slope) != np.sign(slope0)
    steep = (np.sign(slope0) != np.sign(slope1)) & (np.abs(slope) > 3.0 * np.abs(slope0))
    return np.where(wrong, 0.0, np.where(steep, 3.0 * slope0, slope))


def _hermite(x: Floats, y: Floats, slopes: Floats, periodic: bool = False) -> Spline:
    """The pieces that have these values and slopes at the knots."""
    h = np.diff(x).reshape(-1, *(1,) * (y.ndim - 1))
    slope = np.diff(y, axis=0) / h
    t = (slopes[:-1] + slopes[1:] - 2 * slope) / h
    c = np.stack([t / h, (slope - slopes[:-1]) / h - t, slopes[:-1], y[:-1]])
    return Spline(x, c, periodic)
