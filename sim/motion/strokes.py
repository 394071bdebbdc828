"""Smooth motion in continuous time: strokes, paths of a hand, tremor and sway.

Everything is a pure function of t, so that any frame rate and any order of frames see the same
motion.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from pjpdaf.arrays import Floats, readonly

PEAK_OVER_MEAN = 1.875  # of a minimum-jerk stroke: 30 s^2 (1 - s)^2 at s = 1/2


def minimum_jerk(s: float) -> float:
    """Share of the way at share s of the time: 10 s^3 - 15 s^4 + 6 s^5, held outside 0..1.

    Flash and Hogan 1985, The coordination of arm movements.
    """
    if s <= 0.0:
        return 0.0
    if s >= 1.0:
        return 1.0
    return s * s * s * (10.0 + s * (6.0 * s - 15.0))


def minimum_jerk_over(s: Floats) -> Floats:
    """`minimum_jerk` of many shares, to the bit."""
    s = s.clip(0.0, 1.0)
    return np.asarray(s * s * s * (10.0 + s * (6.0 * s - 15.0)))


def minimum_jerk_rate(s: float) -> float:
    """Derivative of `minimum_jerk` by s."""
    if s <= 0.0 or s >= 1.0:
        return 0.0
    return 30.0 * s * s * (1.0 - s) * (1.0 - s)


def minimum_jerk_second(s: float) -> float:
    """Second derivative of `minimum_jerk` by s."""
    if s <= 0.0 or s >= 1.0:
        return 0.0
    return 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s)


_SHARES = np.linspace(0.0, 1.0, 101)
_WAY = _SHARES**3 * (10.0 - 15.0 * _SHARES + 6.0 * _SHARES**2)
_RATE = 30.0 * _SHARES**2 * (1.0 - _SHARES) ** 2


def stroke_duration(way_m: Floats, bulge_m: Floats, peak_mps: float) -> float:
    """Time [s] of a minimum-jerk stroke over way_m (3,), bowed by bulge_m (3,), of this peak speed.

    1.875 A / T for a straight stroke; a strong bow has its peak beside the middle.
    """
    along = way_m + (4.0 * (1.0 - 2.0 * _WAY))[:, None] * bulge_m
    peak = float((_RATE * np.sqrt((along * along).sum(axis=1))).max())
    return peak / peak_mps


@dataclass(frozen=True, eq=False)
class HandState:
    """The planned state of a hand at a moment.

    position_m (3,) palm centre, world; quaternion (4,) wxyz, hand -> world; curls (5,) as in
    `sim.pose.Pose`; air: 0 rests on something, 1 held free (tremor); with_head: share of the head's
    sway that the hand follows; nod_rad: added to the head's pitch (negative = back);
    swivel_rad: swivel of the elbow outward beyond the person's habit.
    """

    position_m: Floats
    quaternion: Floats
    curls: Floats
    air: float = 0.0
    with_head: float = 0.0
    nod_rad: float = 0.0
    swivel_rad: float = 0.0

    def __post_init__(self) -> None:
        for name, shape in (("position_m", (3,)), ("quaternion", (4,)), ("curls", (5,))):
            object.__setattr__(
                self, name, readonly(getattr(self, name), shape, f"HandState.{name}")
            )

    def moved(self, by_m: ArrayLike) -> HandState:
        """The same state displaced by by_m (3,) [m]."""
        return replace(self, position_m=self.position_m + np.asarray(by_m, dtype=np.float64))

    @property
    def row(self) -> Floats:
        """All its numbers (16,), in the order of its fields."""
        rest = [self.air, self.with_head, self.nod_rad, self.swivel_rad]
        return np.concatenate([self.position_m, self.quaternion, self.curls, rest])

    @cached_property
    def rotation(self) -> Floats:
        """Hand -> world (3, 3)."""
        w, x, y, z = (
            self.quaternion / math.sqrt(float(self.quaternion @ self.quaternion))
        ).tolist()
        return np.array(
            [
                [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
            ]
        )


def quaternion_of(rotation: Floats) -> Floats:
    """Unit quaternion (4,) wxyz of a rotation (3, 3); Bar-Itzhack's eigenvector form."""
    r = rotation
    k = np.array(
        [
            [r[0, 0] + r[1, 1] + r[2, 2], r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]],
            [r[2, 1] - r[1, 2], r[0, 0] - r[1, 1] - r[2, 2], r[0, 1] + r[1, 0], r[0, 2] + r[2, 0]],
            [r[0, 2] - r[2, 0], r[0, 1] + r[1, 0], r[1, 1] - r[0, 0] - r[2, 2], r[1, 2] + r[2, 1]],
            [r[1, 0] - r[0, 1], r[0, 2] + r[2, 0], r[1, 2] + r[2, 1], r[2, 2] - r[0, 0] - r[1, 1]],
        ]
    )
    vector: Floats = np.linalg.eigh(k)[1][:, -1]
    return vector if vector[0] >= 0 else -vector


class Move(Protocol):
    """A piece of a hand's path: it goes on from any state, and from end_s on it holds `to`."""

    @property
    def start_s(self) -> float:
        """When it begins [s]."""
        ...

    @property
    def end_s(self) -> float:
        """When it is over [s]."""
        ...

    @property
    def to(self) -> HandState:
        """The state it ends in."""
        ...

    def at(self, t_s: float, start: HandState) -> HandState:
        """The state at t_s >= start_s of a move that began in `start`."""
        ...


@dataclass(frozen=True, eq=False)
class Stroke:
    """A minimum-jerk move from wherever the path is to `to`, on a path bowed by bulge_m (3,).

    The bow is 4 u (1 - u) bulge_m of the travelled share u: it changes neither the ends nor, at the
    middle of the stroke, the speed, whose peak stays 1.875 A / T for bows below a quarter of A.
    """

    start_s: float
    duration_s: float
    to: HandState
    bulge_m: Floats

    def __post_init__(self) -> None:
        object.__setattr__(self, "bulge_m", readonly(self.bulge_m, (3,), "Stroke.bulge_m"))

    def at(self, t_s: float, start: HandState) -> HandState:
        """The state at t_s of a stroke that began in `start`."""
        u = minimum_jerk((t_s - self.start_s) / self.duration_s)
        return between(start, self.to, u, self.bulge_m)

    def rows(self, times_s: Floats, start: HandState) -> Floats:
        """The rows (n, 16) of the states at times_s (n,), to the bit as `at`."""
        u = minimum_jerk_over((times_s - self.start_s) / self.duration_s)[:, None]
        w = 1.0 - u
        a, b = start.row, self.to.row
        nearer = b.copy()
        if float(start.quaternion @ self.to.quaternion) < 0:
            nearer[3:7] *= -1.0
        rows = w * a + u * nearer
        rows[:, :3] += (4.0 * u * w) * self.bulge_m
        return np.where(u <= 0.0, a, np.where(u >= 1.0, b, rows))

    @property
    def end_s(self) -> float:
        """When the stroke is over [s]."""
        return self.start_s + self.duration_s


@dataclass(frozen=True, eq=False)
class Glide:
    """A move that begins with a velocity and ends at rest: the quintic through both.

    velocity_mps, acceleration_mps2 (3,) of the palm at start_s; turn, curls and the rest go on
    smoothly to `to`. It continues a stroke that is broken off (a bounce) without a jump.
    """

    start_s: float
    duration_s: float
    to: HandState
    velocity_mps: Floats
    acceleration_mps2: Floats
    begun: HandState  # the state from which turn and curls go on
    begun_share: float  # share of that change already done at start_s
    begun_rate: float  # share per second at start_s

    @property
    def end_s(self) -> float:
        """When the move is over [s]."""
        return self.start_s + self.duration_s

    def at(self, t_s: float, start: HandState) -> HandState:
        """The state at t_s of a move from where `start` is; turn and the rest from `begun`."""
        T = self.duration_s
        s = min(max((t_s - self.start_s) / T, 0.0), 1.0)
        p0, p1 = start.position_m, self.to.position_m
        v, a = self.velocity_mps * T, self.acceleration_mps2 * (T * T)
        d = p1 - p0
        c3 = 10 * d - 6 * v - 1.5 * a
        c4 = -15 * d + 8 * v + 1.5 * a
        c5 = 6 * d - 3 * v - 0.5 * a
        position = p0 + s * (v + s * (0.5 * a + s * (c3 + s * (c4 + s * c5))))
        # Cubic share from (begun_share, begun_rate) to (1, 0), never back.
        left, rate = 1.0 - self.begun_share, self.begun_rate * T
        share = self.begun_share + s * (rate + s * (3 * left - 2 * rate + s * (rate - 2 * left)))
        state = between(self.begun, self.to, min(max(share, 0.0), 1.0))
        return replace(state, position_m=position)


def between(a: HandState, b: HandState, u: float, bulge_m: Floats | None = None) -> HandState:
    """The state at share u of the way from a to b, on a path bowed by 4 u (1 - u) bulge_m (3,)."""
    if u <= 0.0:
        return a
    if u >= 1.0:
        return b
    w = 1.0 - u
    position = w * a.position_m + u * b.position_m
    if bulge_m is not None:
        position = position + (4.0 * u * w) * bulge_m
    sign = 1.0 if float(a.quaternion @ b.quaternion) >= 0 else -1.0
    return HandState(
        position_m=position,
        quaternion=w * a.quaternion + (sign * u) * b.quaternion,
        curls=w * a.curls + u * b.curls,
        air=w * a.air + u * b.air,
        with_head=w * a.with_head + u * b.with_head,
        nod_rad=w * a.nod_rad + u * b.nod_rad,
        swivel_rad=w * a.swivel_rad + u * b.swivel_rad,
    )


@dataclass(frozen=True, eq=False)
class HandPath:
    """A hand's whole motion: where it starts, and its moves in order of time, never overlapping.

    Between moves the hand holds the state that the last move reached.
    """

    first: HandState
    moves: tuple[Move, ...]

    def __post_init__(self) -> None:
        for before, after in zip(self.moves, self.moves[1:], strict=False):
            if after.start_s < before.start_s:
                raise ValueError(f"moves must be in order of time: {before} before {after}")

    @cached_property
    def _starts(self) -> list[float]:
        return [move.start_s for move in self.moves]

    @cached_property
    def _states(self) -> list[HandState]:
        # The state at each move's start: the end of the move before, or where it is broken off.
        states: list[HandState] = []
        state = self.first
        for index, move in enumerate(self.moves):
            if index:
                state = self.moves[index - 1].at(move.start_s, states[-1])
            states.append(state)
        return states

    def at(self, t_s: float) -> HandState:
        """The state at t_s [s], any t."""
        index = bisect_right(self._starts, t_s) - 1
        if index < 0:
            return self.first
        return self.moves[index].at(t_s, self._states[index])

    def rows(self, times_s: Floats) -> Floats:
        """The rows (n, 16) of the states at times_s (n,), to the bit as `at`."""
        indices = np.searchsorted(self._starts, times_s, side="right") - 1
        rows = np.empty((len(times_s), 16))
        for index in set(indices.tolist()):
            now = indices == index
            move = self.moves[index] if index >= 0 else None
            if isinstance(move, Stroke):
                rows[now] = move.rows(times_s[now], self._states[index])
            else:
                rows[now] = [self.at(t_s).row for t_s in times_s[now].tolist()]
        return rows


@dataclass(frozen=True, eq=False)
class Wobble:
    """A sum of k sines per axis: amplitudes_m (k, 3), frequencies_hz (k, 3), phases_rad (k, 3)."""

    amplitudes_m: Floats
    frequencies_hz: Floats
    phases_rad: Floats

    def __post_init__(self) -> None:
        for name in ("amplitudes_m", "frequencies_hz", "phases_rad"):
            value = readonly(getattr(self, name), (None, 3), f"Wobble.{name}")
            object.__setattr__(self, name, value)

    def at(self, t_s: float) -> Floats:
        """Displacement (3,) [m] at t_s."""
        angles = (2.0 * math.pi * t_s) * self.frequencies_hz + self.phases_rad
        moved: Floats = (self.amplitudes_m * np.sin(angles)).sum(axis=0)
        return moved


def wobble(
    rng: np.random.Generator, amplitude_m: float, low_hz: float, high_hz: float, terms: int = 3
) -> Wobble:
    """A wobble that never leaves a sphere of amplitude_m, with frequencies between the two."""
    shares = rng.uniform(0.4, 1.0, (terms, 3))
    shares *= amplitude_m / math.sqrt(3.0) / shares.sum(axis=0)
    return Wobble(
        amplitudes_m=shares,
        frequencies_hz=rng.uniform(low_hz, high_hz, (terms, 3)),
        phases_rad=rng.uniform(0.0, 2.0 * math.pi, (terms, 3)),
    )
