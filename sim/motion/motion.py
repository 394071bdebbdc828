"""The scripted performer: a plan of hand paths becomes poses of the whole body."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from types import MappingProxyType
from typing import Protocol

import numpy as np

from pjpdaf.arrays import Floats
from sim.anatomy import Anatomy
from sim.contact.separation import separate
from sim.contact.solids import Obstacles, Table, person_solids
from sim.motion.carriage import UPRIGHT, CarriageMotion
from sim.motion.posture import posture
from sim.motion.strokes import HandState, Wobble, minimum_jerk, minimum_jerk_over
from sim.person.kinematics import Arm, shoulders, solve_arm
from sim.pose import Pose, Transform
from sim.scene.extras import WithExtras
from sim.script import Script
from sim.specs import RoomSpec, SceneSpec
from sim.surroundings.seat_and_table import TOP_M
from sim.vectors import about_z

# Of the stature: the elbow above the table, so that the whole sleeve is. Before the edge, and with
# a hand under the table, the elbow may hang lower by _HANGING_M.
_ELBOW_CLEARANCE_H = 0.031
_HANGING_M = 0.25


@dataclass(frozen=True, eq=False)
class Hold:
    """A hand (0 right, 1 left) carries an object from one moment to another [s].

    grip: the object in the hand's frame; None = as the object stands when it is taken.
    put_down: at to_s it is set flat on the table below; False leaves it where the hand lets go, for
    the other hand to take (its hold begins at this to_s).
    """

    name: str
    side: int
    from_s: float
    to_s: float
    grip: Transform | None = None
    put_down: bool = True


@dataclass(frozen=True)
class Cue:
    """A named stretch of the motion from one moment to another [s]: an event of the truth."""

    name: str
    from_s: float
    to_s: float


@dataclass(frozen=True)
class PlannedStep:
    """A step of a script in a plan: who makes it (0 right, 1 left, None the head), when [s].

    where: its place in its file, as the beginning of a message; title: its number and gesture.
    """

    where: str
    title: str
    side: int | None
    from_s: float
    to_s: float


def successive(start_s: float, *ends: tuple[str, float]) -> tuple[Cue, ...]:
    """Cues that follow each other from start_s [s] without a gap: (name, end [s]) of each."""
    cues = []
    for name, end_s in ends:
        cues.append(Cue(name, start_s, end_s))
        start_s = end_s
    return tuple(cues)


class HandMotion(Protocol):
    """A hand's whole motion, a pure function of t (such as `sim.motion.strokes.HandPath`)."""

    def at(self, t_s: float) -> HandState:
        """The state at t_s [s], any t."""
        ...


@dataclass(frozen=True, eq=False)
class MotionPlan:
    """The motion of a sequence: paths of both hands, carried objects, the body's small motions.

    hands, tremor: of the right and the left hand; swivel_rad: the habit of both elbows; holds:
    objects that are carried; cues: named stretches of time; steps: of a script, for messages.
    """

    hands: tuple[HandMotion, HandMotion]
    sway: Wobble
    tremor: tuple[Wobble, Wobble]
    swivel_rad: float
    holds: tuple[Hold, ...] = ()
    cues: tuple[Cue, ...] = ()
    carriage: CarriageMotion = UPRIGHT
    steps: tuple[PlannedStep, ...] = ()


def table_of(room: RoomSpec) -> Table:
    """The table top as an obstacle."""
    return Table(
        top_m=room.table_height_m,
        near_x_m=room.table_near_x_m,
        far_x_m=room.table_near_x_m + room.table_depth_m,
        half_width_m=0.5 * room.table_width_m,
        thickness_m=TOP_M,
    )


def elbow_floor(anatomy: Anatomy, table: Table, palm_m: Floats) -> float:
    """The least height of an elbow [m] whose palm is at palm_m (3,).

    An arm over the table keeps its elbow above it; before the edge and below it may hang.
    """
    before = (table.near_x_m + 0.05 - float(palm_m[0])) / 0.15
    under = (table.top_m - float(palm_m[2])) / 0.05
    hanging = minimum_jerk(max(before, under))
    return table.top_m + _ELBOW_CLEARANCE_H * anatomy.stature_m - _HANGING_M * hanging


def elbow_floor_over(anatomy: Anatomy, table: Table, palms_m: Floats) -> Floats:
    """`elbow_floor` (n,) of palms (n, 3), to the bit."""
    before = (table.near_x_m + 0.05 - palms_m[:, 0]) / 0.15
    under = (table.top_m - palms_m[:, 2]) / 0.05
    hanging = minimum_jerk_over(np.maximum(before, under))
    return np.asarray(table.top_m + _ELBOW_CLEARANCE_H * anatomy.stature_m - _HANGING_M * hanging)


def object_at_rest(room: RoomSpec, name: str) -> Transform:
    """The place of an object of the room before anybody moves it. Raises KeyError."""
    for spec in room.objects:
        if spec.name == name:
            x, y = spec.position_xy_m
            z = room.table_height_m if spec.base_m is None else spec.base_m
            return Transform(np.array([x, y, z]), about_z(spec.yaw_rad))
    raise KeyError(name)


def _after(parent: Transform, child: Transform) -> Transform:
    return Transform(
        parent.position_m + parent.rotation @ child.position_m, parent.rotation @ child.rotation
    )


def _relative(parent: Transform, child: Transform) -> Transform:
    back = parent.rotation.T
    return Transform(back @ (child.position_m - parent.position_m), back @ child.rotation)


@dataclass(frozen=True, eq=False)
class Body:
    """A resolved moment: torso, head, arms, and the planned states of the hands."""

    torso: Transform
    head: Transform
    arms: tuple[Arm, Arm]
    states: tuple[HandState, HandState]

    @property
    def curls(self) -> Floats:
        """Curls (2, 5)."""
        return np.array([self.states[0].curls, self.states[1].curls])


@dataclass(frozen=True, eq=False)
class Performer:
    """A `sim.script.Script`: plays a plan in a scene. Pure in t."""

    scene: SceneSpec
    plan: MotionPlan
    table: Table = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "table", table_of(self.scene.room))

    def obstacles(self, torso: Transform, head: Transform) -> Obstacles:
        """The obstacles of the hands while torso and head are there."""
        return Obstacles(
            self.table,
            person_solids(
                self.scene.anatomy,
                torso.position_m,
                torso.rotation,
                head.position_m,
                head.rotation,
            ),
        )

    def body(self, t_s: float) -> Body:
        """The body at t_s [s], with the least penetration (`sim.motion.measure` judges it)."""
        plan, anatomy = self.plan, self.scene.anatomy
        states = (plan.hands[0].at(t_s), plan.hands[1].at(t_s))
        sway = plan.sway.at(t_s)
        torso, head = posture(anatomy, states, sway, plan.carriage.at(t_s))
        joints = shoulders(anatomy, torso.position_m, torso.rotation)

        def solve(side: int, palm_m: Floats, swivel_rad: float | None) -> Arm:
            state = states[side]
            swivel = plan.swivel_rad + state.swivel_rad if swivel_rad is None else swivel_rad
            return solve_arm(
                anatomy,
                side,
                joints[side],
                palm_m,
                state.rotation,
                swivel,
                elbow_above_m=elbow_floor(anatomy, self.table, palm_m),
                forward=torso.rotation[:, 0],
            )

        right, left = (
            state.position_m + state.air * plan.tremor[side].at(t_s) + state.with_head * sway
            for side, state in enumerate(states)
        )
        curls = np.array([states[0].curls, states[1].curls])
        arms = separate(anatomy, (right, left), solve, curls, self.obstacles(torso, head))
        return Body(torso, head, arms, states)

    @cached_property
    def carried(self) -> tuple[tuple[Hold, Transform, Transform], ...]:
        """Per hold, in order of time: the object in the hand's frame, and where it is left."""
        carried = []
        standing = {
            o.name: object_at_rest(self.scene.room, o.name) for o in self.scene.room.objects
        }
        for hold in sorted(self.plan.holds, key=lambda hold: hold.from_s):
            grip = hold.grip
            if grip is None:
                grip = _relative(self._hand(hold, hold.from_s), standing[hold.name])
            down = _after(self._hand(hold, hold.to_s), grip)
            if hold.put_down:
                x, y, _ = down.position_m.tolist()
                yaw = math.atan2(down.rotation[1, 0], down.rotation[0, 0])
                down = Transform(np.array([x, y, self.table.top_m]), about_z(yaw))
            standing[hold.name] = down
            carried.append((hold, grip, down))
        return tuple(carried)

    def _hand(self, hold: Hold, t_s: float) -> Transform:
        arm = self.body(t_s).arms[hold.side]
        return Transform(arm.palm_m, arm.hand)

    def _objects(self, t_s: float, body: Body) -> Mapping[str, Transform]:
        places = {o.name: object_at_rest(self.scene.room, o.name) for o in self.scene.room.objects}
        for hold, grip, down in self.carried:
            if t_s >= hold.to_s:
                places[hold.name] = down
            elif t_s >= hold.from_s:
                arm = body.arms[hold.side]
                places[hold.name] = _after(Transform(arm.palm_m, arm.hand), grip)
        return MappingProxyType(places)

    def pose(self, t_s: float) -> Pose:
        """The pose at t_s >= 0 [s]."""
        body = self.body(t_s)
        right, left = body.arms
        return Pose(
            time_s=t_s,
            torso=body.torso,
            head=body.head,
            upper_arms=(
                Transform(right.shoulder_m, right.upper_arm),
                Transform(left.shoulder_m, left.upper_arm),
            ),
            forearms=(
                Transform(right.elbow_m, right.forearm),
                Transform(left.elbow_m, left.forearm),
            ),
            hands=(Transform(right.palm_m, right.hand), Transform(left.palm_m, left.hand)),
            curls=body.curls,
            objects=self._objects(t_s, body),
        )

    def events(self, t_s: float) -> tuple[str, ...]:
        """Names of the cues that go on at t_s, and `hold:NAME` for a carried object."""
        named = [cue.name for cue in self.plan.cues if cue.from_s <= t_s < cue.to_s]
        held = [f"hold:{h.name}" for h in self.plan.holds if h.from_s <= t_s < h.to_s]
        return tuple(named + held)


def performer_of(script: Script) -> Performer:
    """The performer of a script, without the movers beside it. Raises TypeError."""
    while isinstance(script, WithExtras):
        script = script.script
    if not isinstance(script, Performer):
        raise TypeError(f"a script of type {type(script).__name__} has no performer")
    return script
