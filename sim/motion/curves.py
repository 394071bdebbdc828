"""Curved paths: rounds of a closed curve, sweeps by way of some states.

Along a curve the speed goes with curvature^(-1/3), the two-thirds power law of drawing hands
(Lacquaniti, Terzuolo and Viviani 1983), start and stop are smooth.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from pjpdaf.arrays import Floats
from sim.motion.splines import Spline, cubic, monotone
from sim.motion.strokes import HandState, between

POWER = -1.0 / 3.0
# Added to the curvature, as a share of that of a circle as long as the curve: without it a straight
# piece would be infinitely fast (the constant of Viviani and Stucchi 1992).
STRAIGHT = 0.05
_TABLE = 512


@dataclass(frozen=True, eq=False)
class Curve:
    """A curve in space, run through once while the phase goes from 0 to 1.

    places: parameter 0..1 -> (3,) [m]; parameters: phase -> parameter, such that a constant rate of
    the phase moves along the curve at a speed that goes with curvature^(-1/3).
    """

    places: Spline
    parameters: Spline
    closed: bool

    def parameter(self, phase: float) -> float:
        """The parameter 0..1 at a phase; any phase of a closed curve; an open curve stops."""
        within = phase % 1.0 if self.closed else min(max(phase, 0.0), 1.0)
        return min(max(float(self.parameters(within)), 0.0), 1.0)

    def at(self, phase: float) -> Floats:
        """The place (3,) [m] at a phase."""
        place: Floats = self.places(self.parameter(phase))
        return place

    def rate(self, phase: float) -> Floats:
        """Derivative (3,) of `at` by the phase [m]."""
        within = phase % 1.0 if self.closed else min(max(phase, 0.0), 1.0)
        slope: Floats = self.places(self.parameter(phase), 1) * float(self.parameters(within, 1))
        return slope


def curve_through(points_m: Floats, closed: bool = False) -> Curve:
    """The smooth curve through points_m (n, 3); a closed curve also goes back to the first."""
    if closed:
        points_m = np.concatenate([points_m, points_m[:1]])
    chords = np.linalg.norm(np.diff(points_m, axis=0), axis=1)
    if len(points_m) < 2 or chords.min() <= 0.0:
        raise ValueError("a curve needs two or more points, each apart from the next")
    # Square roots of chords: the spline does not swing out of its way where chords differ.
    knots = np.concatenate([[0.0], np.cumsum(np.sqrt(chords))])
    places = cubic(knots / knots[-1], points_m, "periodic" if closed else "natural")
    u = np.linspace(0.0, 1.0, _TABLE + 1)
    first, second = places(u, 1), places(u, 2)
    speed = np.linalg.norm(first, axis=1)
    bent = np.linalg.norm(np.cross(first, second), axis=1) / np.maximum(speed, 1e-9) ** 3
    length = float(np.mean(0.5 * (speed[1:] + speed[:-1])))
    pace = (bent + STRAIGHT * 2.0 * math.pi / length) ** POWER
    time_per_u = cubic(u, speed / pace, "periodic" if closed else "not-a-knot")
    phase = time_per_u.antiderivative()(u)
    total = float(phase[-1])
    rates = total / float(time_per_u(0.0)), total / float(time_per_u(1.0))
    return Curve(places, cubic(phase / total, u, rates), closed)


def ellipse(first_m: Floats, second_m: Floats, centre_m: Floats) -> Curve:
    """centre + cos(a) first + sin(a) second, each (3,): half axes if these are at right angles."""
    a = (2.0 * math.pi / 64) * np.arange(64)
    return curve_through(
        centre_m + np.cos(a)[:, None] * first_m + np.sin(a)[:, None] * second_m, closed=True
    )


def figure_eight(first_m: Floats, second_m: Floats, centre_m: Floats) -> Curve:
    """centre + cos(a) first + sin(2 a) second, each (3,): two loops along the first."""
    a = (2.0 * math.pi / 96) * np.arange(96)
    return curve_through(
        centre_m + np.cos(a)[:, None] * first_m + np.sin(2.0 * a)[:, None] * second_m, closed=True
    )


def started(t_s: float, ramp_s: float) -> float:
    """Integral from 0 to t_s [s] of a rate that rises to 1 in ramp_s as
    `sim.motion.strokes.minimum_jerk` does."""
    s = t_s / ramp_s
    if s >= 1.0:
        return t_s - 0.5 * ramp_s
    return ramp_s * s**4 * (2.5 + s * (s - 3.0))


def ramped(t_s: float, duration_s: float, ramp_s: float) -> float:
    """Integral over time [s] of a rate that rises to 1 in ramp_s and falls to 0 in the last ramp_s.

    The rise is that of `started`; the integral at the end is duration_s - ramp_s.
    """
    if t_s <= 0.0:
        return 0.0
    if t_s >= duration_s:
        return duration_s - ramp_s
    if t_s > duration_s - ramp_s:
        return duration_s - ramp_s - ramped(duration_s - t_s, duration_s, ramp_s)
    return started(t_s, ramp_s)


@dataclass(frozen=True, eq=False)
class Rounds:
    """A `sim.motion.strokes.Move`: a number of rounds of a closed curve, from and to rest.

    The curve is displaced to begin where the hand is. ramp_s: to full rate, and back to rest.
    """

    start_s: float
    duration_s: float
    ramp_s: float
    curve: Curve
    rounds: float
    to: HandState

    @property
    def end_s(self) -> float:
        """When it is over [s]."""
        return self.start_s + self.duration_s

    def at(self, t_s: float, start: HandState) -> HandState:
        """The state at t_s of rounds that began in `start`."""
        if t_s >= self.end_s:
            return self.to
        done = ramped(t_s - self.start_s, self.duration_s, self.ramp_s)
        share = done / (self.duration_s - self.ramp_s)
        moved = self.curve.at(self.rounds * share) - self.curve.at(0.0)
        return replace(between(start, self.to, share), position_m=start.position_m + moved)


def rounds(
    start_s: float, start: HandState, curve: Curve, rounds_hz: float, seconds: float, ramp_s: float
) -> Rounds:
    """Rounds at this rate, the hand held as in `start`. ramp_s: below half of the time."""
    count = rounds_hz * (seconds - ramp_s)
    to = replace(start, position_m=start.position_m + curve.at(count) - curve.at(0.0))
    return Rounds(start_s, seconds, ramp_s, curve, count, to)


@dataclass(frozen=True, eq=False)
class Sweep:
    """A `sim.motion.strokes.Move` on a smooth curve through some states, without stopping at them.

    others: parameter of the curve -> all of the state but its position (13,).
    """

    start_s: float
    duration_s: float
    curve: Curve
    others: Spline
    to: HandState

    @property
    def end_s(self) -> float:
        """When it is over [s]."""
        return self.start_s + self.duration_s

    def at(self, t_s: float, start: HandState) -> HandState:
        """The state at t_s; it begins in `start`, which the curve was made for."""
        if t_s <= self.start_s:
            return start
        if t_s >= self.end_s:
            return self.to
        half = 0.5 * self.duration_s
        phase = ramped(t_s - self.start_s, self.duration_s, half) / half
        rest = self.others(self.curve.parameter(phase))
        return HandState(self.curve.at(phase), rest[:4], rest[4:9], *rest[9:].tolist())


def sweep(start_s: float, states: Sequence[HandState], peak_mps: float) -> Sweep:
    """The sweep from the first state by way of the others to the last, with this peak speed."""
    curve = curve_through(np.array([state.position_m for state in states]))
    # With ramps of half the time the phase's rate is 2 minimum_jerk(2 s) up to the middle.
    shares = np.linspace(0.0, 1.0, 201)
    fastest = 0.0
    for s in shares.tolist():
        x = 2.0 * min(s, 1.0 - s)
        rate = 2.0 * x * x * x * (10.0 + x * (6.0 * x - 15.0))
        slope = curve.rate(2.0 * ramped(s, 1.0, 0.5))
        fastest = max(fastest, rate * float(np.linalg.norm(slope)))
    rows, last = [], states[0].quaternion
    for state in states:
        last = state.quaternion if float(state.quaternion @ last) >= 0 else -state.quaternion
        others = [state.air, state.with_head, state.nod_rad, state.swivel_rad]
        rows.append(np.concatenate([last, state.curls, others]))
    # Monotone between states: a curl between two states never leaves them.
    by_parameter = monotone(curve.places.x, np.array(rows))
    return Sweep(start_s, fastest / peak_mps, curve, by_parameter, states[-1])
