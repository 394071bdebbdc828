"""Carriage: how torso and head are held, beyond the posture that the hands ask for."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from pjpdaf.arrays import Floats, readonly
from sim.motion.strokes import minimum_jerk


@dataclass(frozen=True, eq=False)
class Carriage:
    """Torso and head at one moment, beyond the posture that the hands ask for.

    forward_rad: torso about the hips, forward; sideways_rad: to the person's left; turn_rad: about
    the spine, to the left. look_yaw_rad (left), look_pitch_rad (down): the head, added to its gaze.
    head_m (3,): the head displaced in the torso's frame, as far as a neck allows.
    """

    forward_rad: float = 0.0
    sideways_rad: float = 0.0
    turn_rad: float = 0.0
    look_yaw_rad: float = 0.0
    look_pitch_rad: float = 0.0
    head_m: Floats = field(default_factory=lambda: np.zeros(3))

    def __post_init__(self) -> None:
        object.__setattr__(self, "head_m", readonly(self.head_m, (3,), "Carriage.head_m"))


class CarriageMotion(Protocol):
    """The carriage over time, a pure function of t."""

    def at(self, t_s: float) -> Carriage:
        """The carriage at t_s [s], any t."""
        ...


NEUTRAL = Carriage()


@dataclass(frozen=True)
class Upright:
    """A `CarriageMotion` that adds nothing to the posture that the hands ask for."""

    def at(self, t_s: float) -> Carriage:
        """The neutral carriage at any t_s."""
        return NEUTRAL


UPRIGHT = Upright()


@dataclass(frozen=True)
class Lean:
    """A `CarriageMotion`: the torso leans, stays so, and comes back.

    It leans from start_s to there_s, and comes back from leave_s to back_s.
    """

    start_s: float
    there_s: float
    leave_s: float
    back_s: float
    forward_rad: float = 0.0
    sideways_rad: float = 0.0

    def at(self, t_s: float) -> Carriage:
        """The carriage at t_s [s], any t."""
        going = minimum_jerk((t_s - self.start_s) / (self.there_s - self.start_s))
        coming = minimum_jerk((t_s - self.leave_s) / (self.back_s - self.leave_s))
        share = going - coming
        return Carriage(
            forward_rad=share * self.forward_rad, sideways_rad=share * self.sideways_rad
        )


@dataclass(frozen=True, eq=False)
class Leans:
    """A `CarriageMotion` from one carriage to the next, each move minimum-jerk.

    moves: (start_s, duration_s, forward_rad, sideways_rad, turn_rad), in order of time.
    """

    moves: tuple[tuple[float, float, float, float, float], ...]

    def at(self, t_s: float) -> Carriage:
        """The carriage at t_s [s], any t."""
        held = np.zeros(3)
        for start, duration, *goal in self.moves:
            held = held + minimum_jerk((t_s - start) / duration) * (np.array(goal) - held)
        forward, sideways, turn = held.tolist()
        return Carriage(forward, sideways, turn)
