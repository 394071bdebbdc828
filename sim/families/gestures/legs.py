"""Legs: the pieces of a gesture's way, laid on a hand's clock by a peak speed or by a duration."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from sim.contact.contact import Unposable
from sim.families.gestures.gesture import USUAL_SPEED_MPS, Step
from sim.motion.bisection import bisect
from sim.motion.curves import Sweep, sweep
from sim.motion.planner import LEAST_STROKE_S, HandPlanner
from sim.motion.strokes import HandState, Stroke, stroke_duration

_STILL = (0.0, 0.0, 0.0)
_FASTEST_MPS = 6.0  # no hand of a seated person is faster


@dataclass(frozen=True, eq=False)
class Leg:
    """A stroke to a state, or a sweep by way of states, at a share of the gesture's peak speed.

    states: one for a stroke, several for a sweep that does not stop at any but the last. bulge_m:
    bow (3,) of a stroke; least_s: least time of it.
    """

    states: tuple[HandState, ...]
    share: float = 1.0
    bulge_m: ArrayLike = _STILL
    least_s: float = LEAST_STROKE_S


def lay(hand: HandPlanner, legs: Sequence[Leg], step: Step) -> None:
    """Add legs to a hand, at the step's peak speed or so that they take its duration.

    Raises Unposable where no hand is fast enough, or a leg takes its least time, for the duration.
    """
    begun, state, unit = hand.clock_s, hand.state, []
    for leg in legs:  # all of them at a peak speed of 1 m/s
        unit.append(_unhurried(state, leg))
        state = leg.states[-1]
    wanted_s = step.numbers.get("duration")
    speed = step.numbers.get("speed", USUAL_SPEED_MPS)
    if wanted_s is not None:
        least_s = _total_s(unit, legs, _FASTEST_MPS)
        if wanted_s < least_s:
            raise Unposable(
                f"{step.where}: duration: {wanted_s:g} s is too short for this way: it takes "
                f"{least_s:.2f} s or more"
            )
        # Time falls with speed: the greatest speed that does not fall short of the duration.
        slow = bisect(0.0, 1.0, 50, lambda s: _total_s(unit, legs, _speed(s)) <= wanted_s)[1]
        speed = _speed(slow)
    for move, leg in zip(unit, legs, strict=True):
        duration_s = max(move.duration_s / (leg.share * speed), leg.least_s)
        hand.add(replace(move, start_s=hand.clock_s, duration_s=duration_s))
    if wanted_s is not None:
        hand.until(begun + wanted_s)


def _speed(share: float) -> float:
    """Speeds from a millimetre a second (share 0) to the fastest (1), evenly by logarithm."""
    return 0.001 * float((_FASTEST_MPS / 0.001) ** share)


def _unhurried(state: HandState, leg: Leg) -> Stroke | Sweep:
    """The move of a leg from a state, at a peak speed of 1 m/s, begun at 0."""
    if len(leg.states) > 1:
        return sweep(0.0, (state, *leg.states), 1.0)
    (to,) = leg.states
    bow = np.asarray(leg.bulge_m, dtype=np.float64)
    return Stroke(0.0, stroke_duration(to.position_m - state.position_m, bow, 1.0), to, bow)


def _total_s(unit: Sequence[Stroke | Sweep], legs: Sequence[Leg], speed_mps: float) -> float:
    return sum(
        max(move.duration_s / (leg.share * speed_mps), leg.least_s)
        for move, leg in zip(unit, legs, strict=True)
    )
