"""A motion that is a script: objects on the table, and a timed list of gestures."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Literal, Self

from pydantic import Field, PrivateAttr, ValidationInfo, model_validator

from scenarios.spec.faults import dotted
from scenarios.spec.motion.expression import expression_of
from scenarios.spec.motion.steps import (
    AnyStep,
    StepFields,
    numbers_of,
    targets_of,
    words_of,
)
from scenarios.spec.motion.targets import KINDS, ObjectFields
from scenarios.spec.parameters.record import Name, Record
from sim.families.gestures.gesture import Step
from sim.families.gestures.plan import script_family
from sim.motion.stage import Family, Values
from sim.person.kinematics import OUTWARD
from sim.pose import SIDES
from sim.specs import ObjectSpec

MOST_STEPS, MOST_OBJECTS = 500, 40
OTHER = "other "


class ScriptMotion(Record):
    """A motion that is a list of gestures of hands and head, in the order in which they begin."""

    kind: Literal["script"]
    objects: Annotated[dict[Name, ObjectFields], Field(max_length=MOST_OBJECTS)] = Field(
        default_factory=dict
    )
    steps: Annotated[tuple[AnyStep, ...], Field(max_length=MOST_STEPS)]
    _places: tuple[str, ...] = PrivateAttr(default=())

    @model_validator(mode="after")
    def _located(self, info: ValidationInfo) -> Self:
        """Keep where each step stands in its file, for messages of the plan; it is not written."""
        context = info.context or {}
        file, positions = context.get("file"), context.get("positions", {})
        places = []
        for index in range(len(self.steps)):
            path = ("motion", "steps", index)
            line_column = "{}:{}:{}: ".format(file, *positions[path]) if path in positions else ""
            places.append(f"{line_column}{dotted(path)[:-2]}")
        self._places = tuple(places)
        return self

    def family(self, parameters: tuple[str, ...]) -> Family:
        """The family that plays this script. parameters: those of the scenario that are its own."""
        return script_family(parameters, self.concrete_steps, self.concrete_objects)

    def concrete_steps(self, values: Values) -> tuple[Step, ...]:
        """All steps, given values in SI units."""
        return tuple(self._concrete(index, step, values) for index, step in enumerate(self.steps))

    def concrete_objects(self, values: Values) -> tuple[ObjectSpec, ...]:
        """All objects, given values in SI units."""
        return tuple(_object_of(name, given, values) for name, given in self.objects.items())

    def _concrete(self, index: int, step: StepFields, values: Values) -> Step:
        return Step(
            index=index,
            do=step.do,
            who=sides_of(step.who, {n: v for n, v in values.items() if isinstance(v, str)}),
            where=self._places[index],
            label=step.name or "",
            at_s=None if step.at is None else expression_of(step.at, "s").value(values),
            after=step.after or "",
            along=step.along or "",
            wait_s=expression_of(step.wait, "s").value(values),
            numbers=numbers_of(step, values),
            words=words_of(step),
            targets=targets_of(step, values),
        )


def sides_of(who: str, choices: Mapping[str, str]) -> tuple[int, ...]:
    """The sides (0 right, 1 left) that make a step; none for the head.

    choices: parameters that are right or left.
    """
    if who == "head":
        return ()
    if who == "both":
        return 0, 1
    named = who.removeprefix(OTHER)
    side = SIDES.index(choices.get(named, named))
    return (1 - side if who != named else side,)


def _object_of(name: str, given: ObjectFields, values: Values) -> ObjectSpec:
    usual_m, usual_rgb = KINDS[given.kind]
    sizes = [expression_of(size, "m").value(values) for size in given.size or usual_m]
    ahead, aside = (expression_of(length, "m").value(values) for length in given.at)
    side = SIDES.index(str(values.get(given.side, given.side)))
    red, green, blue = given.colour or usual_rgb
    return ObjectSpec(
        name,
        given.kind,
        (sizes[0], sizes[1], sizes[2]),
        (red, green, blue),
        (ahead, OUTWARD[side] * aside),
        expression_of(given.turn, "rad").value(values),
    )
