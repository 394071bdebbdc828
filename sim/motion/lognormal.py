"""Sigma-lognormal strokes: how a hand that talks moves.

Each piece's speed is a lognormal impulse and its direction turns as the impulse is spent; a gesture
is the vector sum of pieces that overlap in time. Plamondon 1995, A kinematic theory of rapid human
movements; O'Reilly and Plamondon 2009, Development of a Sigma-Lognormal representation.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.special import ndtr

from pjpdaf.arrays import Floats, readonly
from sim.motion.strokes import HandState
from sim.vectors import cross, norm

# Standard deviations of ln t after which an impulse counts as spent: 3 millionths are left.
SPENT = 4.5
MAX_TURN_RAD = 1.2  # of a piece of a gesture
LEAST_PIECES, MOST_PIECES = 2, 5


@dataclass(frozen=True, eq=False)
class LognormalPiece:
    """An impulse: speed length_m * lognormal(t - onset_s; mu, sigma) along a circular arc.

    Its direction is cos(phi) along + sin(phi) aside, two unit vectors (3,) at right angles; phi
    goes from from_rad to to_rad with the share of the way, which is
    (1 + erf((ln(t - onset_s) - mu) / (sigma sqrt 2))) / 2.
    """

    onset_s: float
    mu: float
    sigma: float
    length_m: float
    along: Floats
    aside: Floats
    from_rad: float = 0.0
    to_rad: float = 0.0

    def __post_init__(self) -> None:
        for name in ("along", "aside"):
            value = readonly(getattr(self, name), (3,), f"LognormalPiece.{name}")
            object.__setattr__(self, name, value)

    @property
    def from_s(self) -> float:
        """When it begins to be felt [s]."""
        return self.onset_s + math.exp(self.mu - SPENT * self.sigma)

    @property
    def end_s(self) -> float:
        """When it is spent [s]."""
        return self.onset_s + math.exp(self.mu + SPENT * self.sigma)

    def share(self, t_s: float) -> float:
        """Share of the way done at t_s."""
        if t_s <= self.onset_s:
            return 0.0
        z = (math.log(t_s - self.onset_s) - self.mu) / self.sigma
        return 0.5 * math.erfc(-z / math.sqrt(2.0))

    def moved(self, t_s: float) -> Floats:
        """Displacement (3,) [m] since long before: the arc up to the share of the way."""
        share, turn = self.share(t_s), self.to_rad - self.from_rad
        # The chord of an arc: as long as the arc times sinc(half its turn), half the turn aside.
        half = 0.5 * turn * share
        chord = self.length_m * share * float(np.sinc(half / math.pi))
        angle = self.from_rad + half
        moved: Floats = chord * (math.cos(angle) * self.along + math.sin(angle) * self.aside)
        return moved

    def velocity(self, t_s: float) -> Floats:
        """Velocity (3,) [m/s]."""
        if t_s <= self.onset_s:
            return np.zeros(3)
        since = t_s - self.onset_s
        z = (math.log(since) - self.mu) / self.sigma
        density = math.exp(-0.5 * z * z) / (self.sigma * math.sqrt(2.0 * math.pi) * since)
        angle = self.from_rad + (self.to_rad - self.from_rad) * self.share(t_s)
        way = math.cos(angle) * self.along + math.sin(angle) * self.aside
        velocity: Floats = self.length_m * density * way
        return velocity


def piece_of(
    chord_m: Floats, turn_rad: float, normal: Floats, onset_s: float, median_s: float, sigma: float
) -> LognormalPiece:
    """The piece that ends chord_m (3,) from its start, having turned by turn_rad about normal (3,).

    median_s: after the onset, half of the way is done.
    """
    chord = norm(chord_m)
    along = chord_m / chord
    aside = cross(normal, along)
    length = chord / float(np.sinc(0.5 * turn_rad / math.pi))
    return LognormalPiece(
        onset_s,
        math.log(median_s),
        sigma,
        length,
        along,
        aside / norm(aside),
        -0.5 * turn_rad,
        0.5 * turn_rad,
    )


@dataclass(frozen=True, eq=False)
class TalkGesture:
    """A `sim.motion.strokes.Move` by way of some stops, each reached by a vector sum of pieces.

    before: where it begins. Turn, curls and the rest of the state change by the share of the way to
    each stop. Stops overlap in time: the hand need not come to rest at any but the last.
    """

    start_s: float
    before: HandState
    stops: tuple[HandState, ...]
    pieces: tuple[tuple[LognormalPiece, ...], ...]

    @property
    def to(self) -> HandState:
        """The last stop."""
        return self.stops[-1]

    @cached_property
    def end_s(self) -> float:
        """When all pieces are spent [s]."""
        return max(piece.end_s for pieces in self.pieces for piece in pieces)

    @cached_property
    def _numbers(self) -> tuple[Floats, ...]:
        """Of all n pieces: onset, mu, sigma, length, first angle, turn (n,), along, aside (n, 3);
        each piece's share in its leg (legs, n), each leg's change of the state (legs, 13).
        """
        pieces = [piece for leg in self.pieces for piece in leg]
        columns = np.array(
            [
                [p.onset_s, p.mu, p.sigma, p.length_m, p.from_rad, p.to_rad - p.from_rad]
                for p in pieces
            ]
        ).T
        along, aside = np.array([p.along for p in pieces]), np.array([p.aside for p in pieces])
        legs = np.repeat(np.arange(len(self.pieces)), [len(leg) for leg in self.pieces])
        lengths = np.where(legs == np.arange(len(self.pieces))[:, None], columns[3], 0.0)
        states = np.array([_rest(state) for state in (self.before, *self.stops)])
        shares = lengths / lengths.sum(axis=1, keepdims=True)
        return (*columns, along, aside, shares, np.diff(states, axis=0))

    def at(self, t_s: float, start: HandState) -> HandState:
        """The state at t_s, displaced as `start` is from `before`."""
        if t_s >= self.end_s:
            return self.to
        onset, mu, sigma, length, first, turn, along, aside, shares, changes = self._numbers
        # As `LognormalPiece.moved`, for all pieces at once.
        share = ndtr((np.log(np.maximum(t_s - onset, 1e-12)) - mu) / sigma)
        half = 0.5 * turn * share
        chord = length * share * np.sinc(half / math.pi)
        moved = (chord * np.cos(first + half)) @ along + (chord * np.sin(first + half)) @ aside
        rest = _rest(start) + (shares @ share) @ changes
        return HandState(start.position_m + moved, rest[:4], rest[4:9], *rest[9:].tolist())


def _rest(state: HandState) -> Floats:
    """All of a state but its position (13,)."""
    others = [state.air, state.with_head, state.nod_rad, state.swivel_rad]
    return np.concatenate([state.quaternion, state.curls, others])


def talk_gesture(
    rng: np.random.Generator,
    start_s: float,
    start: HandState,
    stops: Sequence[HandState],
    peaks_mps: Sequence[float],
    pause_s: float = 0.0,
    straight: Collection[int] = (),
) -> TalkGesture:
    """A gesture from `start` by way of the stops, each leg a random sum of 2-5 pieces.

    peaks_mps: the peak speed of each leg by itself. pause_s: from the time when a leg is nearly
    done to the start of the next; below 0 they run into each other. straight: the numbers of legs,
    from 0, that go straight, so that a hand comes off a table, and down on it, without dipping in.
    """
    legs, clock, here, kept = [], start_s, start, []
    for number, (stop, peak) in enumerate(zip(stops, peaks_mps, strict=True)):
        way = stop.position_m - here.position_m
        leg = _leg(rng, way, peak, 0.0 if number in straight else 1.0)
        begins = min(piece.from_s for piece in leg)
        leg = tuple(_shifted(piece, clock - begins) for piece in leg)
        legs.append(leg)
        # The next leg starts when this leg is done to the last three hundredths of each impulse.
        nearly = max(piece.onset_s + math.exp(piece.mu + 1.9 * piece.sigma) for piece in leg)
        clock = max(nearly + pause_s, clock + 0.1)
        if float(stop.quaternion @ here.quaternion) < 0:
            # The same turn; of its two quaternions the nearer, as the two must not be mixed.
            stop = replace(stop, quaternion=-stop.quaternion)
        kept.append(stop)
        here = stop
    return TalkGesture(start_s, start, tuple(kept), tuple(legs))


def _leg(
    rng: np.random.Generator, way_m: Floats, peak_mps: float, astray: float
) -> tuple[LognormalPiece, ...]:
    """2-5 overlapping pieces whose chords add up to way_m (3,), with this peak speed.

    astray: 0 for straight pieces in line, 1 for chords and turns as a talking hand has them.
    """
    count = int(rng.integers(LEAST_PIECES, MOST_PIECES + 1))
    shares = rng.dirichlet(np.full(count, 6.0))
    strays = rng.normal(0.0, 0.18 * astray * norm(way_m), (count, 3))
    chords = shares[:, None] * way_m + strays - strays.mean(axis=0)
    turns = astray * rng.uniform(-MAX_TURN_RAD, MAX_TURN_RAD, count)
    normals = rng.normal(size=(count, 3))
    sigmas = rng.uniform(0.18, 0.32, count)
    medians = rng.uniform(0.85, 1.15, count)
    onsets = np.concatenate([[0.0], np.cumsum(rng.uniform(0.2, 0.5, count - 1))])
    pieces = tuple(
        piece_of(chord, turn, normal, onset, median, sigma)
        for chord, turn, normal, onset, median, sigma in zip(
            chords,
            turns.tolist(),
            normals,
            onsets.tolist(),
            medians.tolist(),
            sigmas.tolist(),
            strict=True,
        )
    )
    last = max(piece.end_s for piece in pieces)
    fastest = _fastest(pieces, np.linspace(0.0, min(last, 4.0), 161))
    slower = fastest / peak_mps
    return tuple(
        replace(piece, onset_s=piece.onset_s * slower, mu=piece.mu + math.log(slower))
        for piece in pieces
    )


def _fastest(pieces: Sequence[LognormalPiece], times_s: Floats) -> float:
    """Greatest speed of the pieces together at these times (n,) [m/s].

    The speeds of all times at once serve to choose the few times that may be the fastest; at these
    the speed is that of `LognormalPiece.velocity`, to the last bit.
    """
    total = np.zeros((len(times_s), 3))
    for p in pieces:
        since = np.maximum(times_s - p.onset_s, 1e-300)
        z = (np.log(since) - p.mu) / p.sigma
        density = np.exp(-0.5 * z * z) / (p.sigma * math.sqrt(2.0 * math.pi) * since)
        angle = p.from_rad + (p.to_rad - p.from_rad) * ndtr(z)
        way = np.cos(angle)[:, None] * p.along + np.sin(angle)[:, None] * p.aside
        total += (p.length_m * density)[:, None] * way
    speeds = np.sqrt((total * total).sum(axis=1))
    may_be = times_s[speeds >= speeds.max() * (1.0 - 1e-9)]
    return max(
        norm(np.sum([piece.velocity(t_s) for piece in pieces], axis=0)) for t_s in may_be.tolist()
    )


def _shifted(piece: LognormalPiece, by_s: float) -> LognormalPiece:
    return replace(piece, onset_s=piece.onset_s + by_s)
