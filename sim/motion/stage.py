"""What a family of motion plans with: the scene, its values, its random streams."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from pjpdaf.errors import BenchError
from sim.motion.motion import UPRIGHT, CarriageMotion, Cue, HandMotion, Hold, MotionPlan
from sim.motion.planner import HandPlanner, resting
from sim.motion.strokes import HandState, wobble
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
    """What a family plans with: the scene, its values, its random streams, how long it plays."""

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
        """The plan of these hands with this person's sway and tremor."""
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
    """For a family that needs nothing on the table."""
    return ()


@dataclass(frozen=True)
class Family:
    """A family's entry: the parameters it needs, the objects it puts on the table, its plan."""

    parameters: tuple[str, ...]
    objects: Callable[[Values], tuple[ObjectSpec, ...]]
    plan: Callable[[Stage], MotionPlan]
