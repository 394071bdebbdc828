"""Openings: bad starts with crossed hands or a hidden hand, put before a motion plan."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from sim.contact.arm_shape import height_above_table
from sim.motion.carriage import Carriage, CarriageMotion
from sim.motion.curves import sweep
from sim.motion.motion import Cue, HandMotion, MotionPlan
from sim.motion.planner import curled, raised
from sim.motion.stage import Stage
from sim.motion.strokes import HandPath, HandState, between, quaternion_of
from sim.person.kinematics import OUTWARD, hand_rotation
from sim.surfaces.assets import check_word

OPENINGS = ("apart", "crossed", "hidden")
OPENING_S = 0.7  # how long the hands stay as they are at the start
MOVE_S = 1.0  # of a hand to its place
_FOLLOWS_S = 0.15  # the lower of two crossed hands waits for the upper hand to leave


def with_opening(stage: Stage, plan: MotionPlan, kind: str) -> MotionPlan:
    """The plan, begun from another start: later by the time that it takes, otherwise the same.

    kind: one of OPENINGS. apart: as planned. crossed: a forearm lies over the other, each hand on
    the other's side. hidden: a hand hangs beside the thigh, behind the table. Raises ValueError
    for another word.
    """
    check_word("start", kind, OPENINGS)
    if kind == "apart":
        return plan
    # The side whose hand is hidden, or lies over the other.
    first = int(stage.streams("opening").integers(2))
    goals = (plan.hands[0].at(0.0), plan.hands[1].at(0.0))
    paths = [HandPath(goals[0], ()), HandPath(goals[1], ())]
    if kind == "crossed":
        over, under = _crossed(stage, first)
        paths[first] = _path((over, _above(over, goals[first]), goals[first]), OPENING_S)
        goal = goals[1 - first]
        paths[1 - first] = _path((under, _above(under, goal), goal), OPENING_S + _FOLLOWS_S)
    else:
        paths[first] = _path((*_from_under(stage, first), goals[first]), OPENING_S)
    later_s = OPENING_S + MOVE_S + (_FOLLOWS_S if kind == "crossed" else 0.0)
    cue = Cue(f"start:{kind}", 0.0, OPENING_S)
    right, left = (_Then(path, hand, later_s) for path, hand in zip(paths, plan.hands, strict=True))
    return replace(
        plan,
        hands=(right, left),
        holds=tuple(
            replace(hold, from_s=hold.from_s + later_s, to_s=hold.to_s + later_s)
            for hold in plan.holds
        ),
        cues=(
            cue,
            *(Cue(c.name, c.from_s + later_s, c.to_s + later_s) for c in plan.cues),
        ),
        carriage=_Later(plan.carriage, later_s),
        steps=tuple(
            replace(step, from_s=step.from_s + later_s, to_s=step.to_s + later_s)
            for step in plan.steps
        ),
    )


@dataclass(frozen=True, eq=False)
class _Then:
    """A hand's motion that begins later_s after a path which ends where it starts."""

    path: HandPath
    motion: HandMotion
    later_s: float

    def at(self, t_s: float) -> HandState:
        """The state at t_s [s], any t."""
        if t_s < self.later_s:
            return self.path.at(t_s)
        return self.motion.at(t_s - self.later_s)


@dataclass(frozen=True, eq=False)
class _Later:
    """A carriage that begins later_s, and is as at its start until then."""

    motion: CarriageMotion
    later_s: float

    def at(self, t_s: float) -> Carriage:
        """The carriage at t_s [s], any t."""
        return self.motion.at(max(t_s - self.later_s, 0.0))


def _path(states: Sequence[HandState], start_s: float) -> HandPath:
    """A sweep through the states that begins at start_s and takes MOVE_S."""
    unhurried = sweep(start_s, states, peak_mps=1.0)
    return HandPath(states[0], (replace(unhurried, duration_s=MOVE_S),))


def _crossed(stage: Stage, over: int) -> tuple[HandState, HandState]:
    """Both hands on the other's side: the first's forearm lies over the second's, on the table."""
    anatomy, room = stage.scene.anatomy, stage.scene.room
    k = anatomy.stature_m / 1.72
    states = []
    for side in (over, 1 - over):
        upper = side == over
        rotation = hand_rotation(side, 0.95, 0.10 if upper else 0.03, 0.07)
        curls = curled(0.15, thumb=0.1)
        z = room.table_height_m + height_above_table(anatomy, side, rotation, curls) + 1e-3
        place = np.array(
            [
                room.table_near_x_m + (0.17 if upper else 0.14) * k,
                -OUTWARD[side] * 0.085 * k,
                z + (0.078 * k if upper else 0.0),
            ]
        )
        states.append(HandState(place, quaternion_of(rotation), curls, air=0.0))
    return states[0], states[1]


def _above(start: HandState, goal: HandState) -> HandState:
    """A state on the way that lets a hand pass over an object beside its place."""
    place = 0.4 * start.position_m + 0.6 * goal.position_m
    place[2] = max(float(start.position_m[2]), float(goal.position_m[2])) + 0.15
    place[0] -= 0.05
    return replace(between(start, goal, 0.6), position_m=place)


def _from_under(stage: Stage, side: int) -> tuple[HandState, ...]:
    """From beside the thigh, below the table, up before its near edge and over it."""
    room, outward = stage.scene.room, OUTWARD[side]
    near, top = room.table_near_x_m, room.table_height_m

    def at(x: float, y: float, z: float, down_rad: float) -> HandState:
        return raised(side, [near + x, outward * y, top + z], 0.0, down_rad, 0.0, curl=0.1)

    return at(-0.10, 0.34, -0.22, 0.9), at(-0.10, 0.35, 0.02, 0.75), at(0.0, 0.33, 0.10, 0.3)
