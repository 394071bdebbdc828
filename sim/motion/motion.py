"""The scripted performer: a plan of hand paths becomes poses of the whole body."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from types import MappingProxyType
from typing import Protocol

import numpy as np

from pjpdaf.arrays import Floats, readonly
from sim.anatomy import Anatomy
from sim.contact.separation import separate
from sim.contact.solids import Obstacles, Table, person_solids
from sim.motion.strokes import HandState, Wobble, minimum_jerk
from sim.person.kinematics import Arm, shoulders, solve_arm
from sim.pose import Pose, Transform
from sim.scene.room import TOP_M
from sim.specs import RoomSpec, SceneSpec
from sim.vectors import about_x, about_y, about_z, norm

_HIP_HEIGHT_H = 0.245  # of the stature: the pivot of the torso (seat height, as in `Anatomy.of`)
_HEAD_FORWARD_M = 0.02  # the head's centre stands ahead of the mid-shoulder point
# Of the stature: the elbow above the table, so that the whole sleeve is. Before the edge, and with
# a hand under the table, the elbow may hang lower by _HANGING_M.
_ELBOW_CLEARANCE_H = 0.031
_HANGING_M = 0.25
_MAX_LEAN_RAD = math.radians(15.0)
_TORSO_SHARE = 0.4  # of the head's sway


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
    """Something worth a name that goes on from one moment to another [s]."""

    name: str
    from_s: float
    to_s: float


class HandMotion(Protocol):
    """A hand's whole motion, pure in t (`sim.motion.strokes.HandPath` is one)."""

    def at(self, t_s: float) -> HandState:
        """The state at t_s [s], any t."""
        ...


@dataclass(frozen=True, eq=False)
class Carriage:
    """How torso and head are held at one moment, beyond what the hands ask for.

    forward_rad: torso about the hips, forward; sideways_rad: to the person's left; turn_rad: about
    the spine, to the left. look_yaw_rad (left), look_pitch_rad (down): the head, added to its gaze.
    head_m (3,): the head displaced in the torso's frame, by what a neck allows.
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
    """The carriage over time, pure in t."""

    def at(self, t_s: float) -> Carriage:
        """The carriage at t_s [s], any t."""
        ...


_UPRIGHT = Carriage()


@dataclass(frozen=True)
class Upright:
    """Nothing beyond what the hands ask for."""

    def at(self, t_s: float) -> Carriage:
        """Always the same."""
        return _UPRIGHT


UPRIGHT = Upright()


@dataclass(frozen=True, eq=False)
class MotionPlan:
    """What a performer does: paths of both hands, what they hold, and the body's small motions."""

    hands: tuple[HandMotion, HandMotion]
    sway: Wobble
    tremor: tuple[Wobble, Wobble]
    swivel_rad: float
    holds: tuple[Hold, ...] = ()
    cues: tuple[Cue, ...] = ()
    carriage: CarriageMotion = UPRIGHT


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


def object_at_rest(room: RoomSpec, name: str) -> Transform:
    """Where an object of the room stands before anybody moves it. Raises KeyError."""
    for thing in room.objects:
        if thing.name == name:
            x, y = thing.position_xy_m
            z = room.table_height_m if thing.base_m is None else thing.base_m
            return Transform(np.array([x, y, z]), about_z(thing.yaw_rad))
    raise KeyError(name)


def posture(
    anatomy: Anatomy,
    hands: tuple[HandState, HandState],
    sway_m: Floats,
    carriage: Carriage = _UPRIGHT,
) -> tuple[Transform, Transform]:
    """Torso and head for what the hands do, displaced by sway_m (3,).

    The torso leans forward, up to 15 degrees, where an arm would otherwise be stretched, and as the
    carriage says; the head turns a little towards hands in the air.
    """
    pivot = np.array([0.0, 0.0, _HIP_HEIGHT_H * anatomy.stature_m])
    upright = np.array([0.0, 0.0, anatomy.mid_shoulder_height_m])
    arm_m = anatomy.upper_arm_m + anatomy.forearm_m
    spine_m = norm(upright - pivot)
    lean = 0.0
    held = _held(carriage)
    for side, shoulder in enumerate(shoulders(anatomy, pivot + held @ (upright - pivot), held)):
        state = hands[side]
        wrist = state.position_m - anatomy.wrist_to_palm_m * state.rotation[:, 0]
        short = (norm(wrist - shoulder) - 0.95 * arm_m) / 0.015
        soft = short if short > 30 else math.log1p(math.exp(short))
        lean += 1.3 * 0.015 * soft / spine_m
    turn = about_y(_MAX_LEAN_RAD * math.tanh(lean / _MAX_LEAN_RAD)) @ held
    torso = Transform(pivot + turn @ (upright - pivot) + _TORSO_SHARE * sway_m, turn)
    above = np.array([_HEAD_FORWARD_M, 0.0, anatomy.neck_to_head_centre_m]) + carriage.head_m
    centre = torso.position_m + turn @ above + (1 - _TORSO_SHARE) * sway_m
    weight = yaw = pitch = 0.0
    for state in hands:
        dx, dy, dz = (state.position_m - upright - above).tolist()
        drawn = (0.05 + state.air) * (1.0 - state.with_head)
        weight += drawn
        yaw += drawn * math.atan2(dy, max(dx, 0.15))
        pitch += drawn * math.atan2(-dz, max(dx, 0.15))
    yaw *= 0.25 / (weight + 0.3)
    pitch = 0.08 + 0.15 * pitch / (weight + 0.3) + sum(state.nod_rad for state in hands)
    yaw += carriage.turn_rad + carriage.look_yaw_rad
    pitch += carriage.look_pitch_rad
    return torso, Transform(centre, about_z(yaw) @ about_y(pitch))


def _held(carriage: Carriage) -> Floats:
    if carriage is _UPRIGHT:
        return np.eye(3)
    lean = about_x(-carriage.sideways_rad) @ about_y(carriage.forward_rad)
    return lean @ about_z(carriage.turn_rad)


def _after(parent: Transform, child: Transform) -> Transform:
    return Transform(
        parent.position_m + parent.rotation @ child.position_m, parent.rotation @ child.rotation
    )


def _relative(parent: Transform, child: Transform) -> Transform:
    back = parent.rotation.T
    return Transform(back @ (child.position_m - parent.position_m), back @ child.rotation)


@dataclass(frozen=True, eq=False)
class Body:
    """A resolved moment: torso, head, arms, and what the hands were told."""

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
    _table: Table = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "_table", table_of(self.scene.room))

    def obstacles(self, torso: Transform, head: Transform) -> Obstacles:
        """What the hands must keep out of while torso and head are there."""
        return Obstacles(
            self._table,
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
                elbow_above_m=elbow_floor(anatomy, self._table, palm_m),
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
    def _carried(self) -> tuple[tuple[Hold, Transform, Transform], ...]:
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
                down = Transform(np.array([x, y, self._table.top_m]), about_z(yaw))
            standing[hold.name] = down
            carried.append((hold, grip, down))
        return tuple(carried)

    def _hand(self, hold: Hold, t_s: float) -> Transform:
        arm = self.body(t_s).arms[hold.side]
        return Transform(arm.palm_m, arm.hand)

    def _objects(self, t_s: float, body: Body) -> Mapping[str, Transform]:
        places = {o.name: object_at_rest(self.scene.room, o.name) for o in self.scene.room.objects}
        for hold, grip, down in self._carried:
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
