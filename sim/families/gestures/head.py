"""Gestures of head and torso: look, nod, shake, lean."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from pjpdaf.arrays import Floats
from sim.families.gestures.gesture import HEAD, Gesture, Place, Quantity, Step
from sim.families.gestures.targets import point_of
from sim.motion.carriage import Carriage, CarriageMotion
from sim.motion.posture import posture
from sim.motion.strokes import minimum_jerk

if TYPE_CHECKING:
    from sim.families.gestures.rehearsal import Rehearsal

# Of the goals of a head's moves.
FORWARD, SIDEWAYS, YAW, PITCH = range(4)


@dataclass(frozen=True, eq=False)
class HeadPath:
    """A `CarriageMotion` from goal to goal, each move minimum-jerk.

    moves: (start [s], duration [s], goal (4,) [rad]: torso forward and sideways (left), head turned
    left and down).
    """

    moves: tuple[tuple[float, float, Floats], ...]

    def at(self, t_s: float) -> Carriage:
        """The carriage at t_s [s], any t."""
        held = np.zeros(4)
        for start_s, duration_s, goal in self.moves:
            if t_s <= start_s:
                break
            held = held + minimum_jerk((t_s - start_s) / duration_s) * (goal - held)
        forward, sideways, yaw, pitch = held.tolist()
        return Carriage(forward, sideways, 0.0, yaw, pitch)


@dataclass(frozen=True, eq=False)
class Together:
    """A `CarriageMotion`: the sum of some."""

    parts: tuple[CarriageMotion, ...]

    def at(self, t_s: float) -> Carriage:
        """The carriage at t_s [s], any t."""
        held = [part.at(t_s) for part in self.parts]
        return Carriage(
            sum(c.forward_rad for c in held),
            sum(c.sideways_rad for c in held),
            sum(c.turn_rad for c in held),
            sum(c.look_yaw_rad for c in held),
            sum(c.look_pitch_rad for c in held),
            np.sum([c.head_m for c in held], axis=0),
        )


@dataclass
class HeadPlanner:
    """Collects the moves of the head; `clock_s` is when the last is over."""

    clock_s: float
    moves: list[tuple[float, float, Floats]] = field(default_factory=list)

    @property
    def goal(self) -> Floats:
        """Where the head is once all moves so far are over (4,)."""
        return self.moves[-1][2] if self.moves else np.zeros(4)

    def move(self, changes: dict[int, float], duration_s: float) -> None:
        """Go to a goal that differs from the last in these components."""
        goal = self.goal.copy()
        for component, value in changes.items():
            goal[component] = value
        self.moves.append((self.clock_s, duration_s, goal))
        self.clock_s += duration_s

    def path(self) -> HeadPath:
        """The path of all moves so far."""
        return HeadPath(tuple(self.moves))


def _look(rehearsal: Rehearsal, step: Step, side: int) -> None:
    """Turn the head by angles, or towards a target as it is seen from a resting posture."""
    stage = rehearsal.stage
    if "to" in step.targets:
        _, head = posture(stage.scene.anatomy, (stage.rest(0), stage.rest(1)), np.zeros(3))
        way = point_of(rehearsal, step.targets["to"], 1) - head.position_m
        yaw = math.atan2(way[1], way[0])
        own = math.atan2(-head.rotation[2, 0], head.rotation[0, 0])
        pitch = math.atan2(-way[2], math.hypot(way[0], way[1])) - own
        # As far as a neck turns with ease; the eyes do the rest.
        turns = {YAW: min(max(yaw, -0.8), 0.8), PITCH: min(max(pitch, -0.4), 0.5)}
    else:
        turns = {YAW: step.number("turn"), PITCH: step.number("down")}
    rehearsal.head.move(turns, step.number("duration"))
    rehearsal.head.clock_s += step.number("hold")


def _swing(component: int) -> Gesture:
    """Nod or shake: to and fro about where the head is, and back there."""

    def play(rehearsal: Rehearsal, step: Step, side: int) -> None:
        head, half_s = rehearsal.head, 0.5 / step.number("rate")
        middle = float(head.goal[component])
        first = 1.0 if component == PITCH else 0.5
        for k in range(round(step.number("times"))):
            sign = 1.0 if component == PITCH or k % 2 == 0 else -1.0
            head.move({component: middle + sign * first * step.number("size")}, half_s)
            head.move({component: middle}, half_s)

    nods = component == PITCH
    return Gesture(
        "nods" if nods else "shakes the head",
        (
            Quantity("size", "rad", 0.02, 0.6, "down" if nods else "side to side", 0.2),
            Quantity("rate", "Hz", 0.3, 4.0, "how fast", 1.0),
            Quantity("times", "1", 1, 50, "how often", 2),
        ),
        play,
        (HEAD,),
    )


def _lean(rehearsal: Rehearsal, step: Step, side: int) -> None:
    goal = {FORWARD: step.number("forward"), SIDEWAYS: step.number("sideways")}
    rehearsal.head.move(goal, step.number("duration"))
    rehearsal.head.clock_s += step.number("hold")


_HOLD = Quantity("hold", "s", 0.0, 600.0, "how long it stays so", 0.0)
GESTURES = {
    "look": Gesture(
        "turns the head by angles or to a target",
        (
            Place("to", "what it looks at, instead of angles", required=False),
            Quantity("turn", "rad", -0.8, 0.8, "to the person's left", 0.0),
            Quantity("down", "rad", -0.4, 0.5, "down", 0.0),
            Quantity("duration", "s", 0.15, 60.0, "time that the turn takes", 0.6),
            _HOLD,
        ),
        _look,
        (HEAD,),
    ),
    "nod": _swing(PITCH),
    "shake": _swing(YAW),
    "lean": Gesture(
        "leans with the torso",
        (
            Quantity("forward", "rad", -0.3, 0.5, "forward", 0.0),
            Quantity("sideways", "rad", -0.4, 0.4, "to the person's left", 0.0),
            Quantity("duration", "s", 0.3, 60.0, "time that it takes", 1.0),
            _HOLD,
        ),
        _lean,
        (HEAD,),
    ),
}
