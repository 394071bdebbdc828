"""The stage: the input of a family's plan; and the record of a family of motion."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.errors import BenchError
from sim.motion.carriage import UPRIGHT, CarriageMotion
from sim.motion.motion import Cue, HandMotion, Hold, MotionPlan, object_at_rest
from sim.motion.planner import HandPlanner, resting
from sim.motion.strokes import HandState, wobble
from sim.pose import Transform
from sim.specs import ObjectSpec, SceneSpec

Value = float | str
Values = Mapping[str, Value]
Streams = Callable[[str], np.random.Generator]  # name -> generator of that name

STILL_S = 1.1  # hands apart and still at the start: the thesis's first frames


def number(values: Values, name: str) -> float:
    """A numeric value in SI units. Raises BenchError where the parameter is a choice or a file."""
    value = values[name]
    if isinstance(value, str):
        raise BenchError(
            f"parameter {name}: must be a number in this family of motion, got {value[:60]!r}; "
            "give it a unit, a range and a nominal distribution instead of choices or a file"
        )
    return float(value)


def side_of(values: Values, name: str) -> int:
    """0 for "right", 1 for "left"."""
    return {"right": 0, "left": 1}[str(values[name])]


@dataclass(frozen=True, eq=False)
class Stage:
    """The input of a family's plan: scene, parameter values in SI units, random streams, duration.

    streams: name -> generator of that name, the same for every call with a seed.
    """

    scene: SceneSpec
    values: Values
    streams: Streams
    duration_s: float

    def number(self, name: str) -> float:
        """A numeric value in SI units."""
        return number(self.values, name)

    def side(self, name: str) -> int:
        """0 for "right", 1 for "left"."""
        return side_of(self.values, name)

    @property
    def start_s(self) -> float:
        """When the motion begins [s]: after the still start and the parameter `wait`."""
        return STILL_S + self.number("wait")

    def planners(self, start_s: float = 0.0) -> tuple[HandPlanner, HandPlanner]:
        """Planners of the right and the left hand, at rest on the table until start_s [s]."""
        hands = (HandPlanner(self.rest(0)), HandPlanner(self.rest(1)))
        for hand in hands:
            hand.until(start_s)
        return hands

    def object_named(self, name: str) -> tuple[ObjectSpec, Transform]:
        """An object of the room and where it stands at the start. Raises KeyError."""
        place = object_at_rest(self.scene.room, name)
        return next(o for o in self.scene.room.objects if o.name == name), place

    @property
    def centre_m(self) -> Floats:
        """The middle of a motion before the chest (3,) [m]: parameters `centre_x` and `height`."""
        height = self.scene.room.table_height_m + self.number("height")
        return np.array([self.number("centre_x"), 0.0, height])

    def rest(self, side: int, ahead_m: float = 0.0, outward_m: float = 0.0) -> HandState:
        """The hand at its place on the table, or shifted from it."""
        return resting(
            self.scene,
            side,
            self.number("rest_x") + ahead_m,
            self.number("rest_y") + outward_m,
            self.number("hand_inward"),
            self.number("hand_curl"),
        )

    def plan(
        self,
        hands: tuple[HandPlanner | HandMotion, HandPlanner | HandMotion],
        holds: tuple[Hold, ...] = (),
        cues: tuple[Cue, ...] = (),
        carriage: CarriageMotion = UPRIGHT,
    ) -> MotionPlan:
        """The motion plan of these hands (right, left) with this person's sway and tremor."""
        right, left = (h.path() if isinstance(h, HandPlanner) else h for h in hands)
        sway = wobble(self.streams("sway"), self.number("head_sway"), 0.2, 0.5)
        tremor = tuple(
            wobble(self.streams(f"tremor-{side}"), self.number("tremor"), 0.5, 1.6)
            for side in (0, 1)
        )
        return MotionPlan(
            hands=(right, left),
            sway=sway,
            tremor=(tremor[0], tremor[1]),
            swivel_rad=self.number("elbow_swivel"),
            holds=holds,
            cues=cues,
            carriage=carriage,
        )


def no_objects(values: Values) -> tuple[ObjectSpec, ...]:
    """The objects of a family that puts nothing on the table."""
    return ()


@dataclass(frozen=True)
class Family:
    """A kind of motion: the parameters that it needs, its plan, its objects on the table."""

    parameters: tuple[str, ...]
    plan: Callable[[Stage], MotionPlan]
    objects: Callable[[Values], tuple[ObjectSpec, ...]] = no_objects
