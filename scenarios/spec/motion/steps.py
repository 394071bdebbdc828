"""Steps of a script as a file gives them: a record for each gesture, made of its fields."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import Field, SerializerFunctionWrapHandler, create_model, model_serializer

from scenarios.spec.motion.expression import expression_of, quantity_type
from scenarios.spec.motion.targets import LENGTH, Quantified, TargetFields
from scenarios.spec.parameters.record import Name, Record, Text
from sim.families.gestures.gesture import (
    BOTH,
    HAND,
    HEAD,
    Gesture,
    ObjectName,
    Place,
    Quantity,
    StepField,
    Target,
    Word,
)
from sim.families.gestures.registry import GESTURES
from sim.motion.stage import STILL_S, Values

LONGEST_S = 20_000.0
TIMES = {"at": (STILL_S, LONGEST_S), "wait": (0.0, LONGEST_S)}
if TYPE_CHECKING:
    Moment = float | str
    Wait = float | str
else:
    Moment = quantity_type("s", *TIMES["at"], "when it begins, from the episode's start")
    Wait = quantity_type("s", *TIMES["wait"], "stillness before it")


class StepFields(Record):
    """What every step has: who makes it, which gesture, and when it begins.

    name: for other steps to refer to; after, along (in a file `with`): names of earlier steps.
    """

    who: Annotated[
        Text,
        Field(description="right, left, both, head, a parameter that is right or left, other NAME"),
    ]
    do: Text
    name: Name | None = None
    at: Moment | None = None
    after: Annotated[Name | None, Field(description="begins when that step is over")] = None
    along: Annotated[
        Name | None, Field(alias="with", description="begins together with that step")
    ] = None
    wait: Wait = 0.0

    @model_serializer(mode="wrap")
    def _without_what_is_absent(self, written: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """A field that is not given is not part of a digest."""
        return {key: value for key, value in written(self).items() if value is not None}


def _type_of(field: StepField) -> tuple[Any, Any]:
    """Type and default of a field, for `create_model`."""
    if isinstance(field, Quantity):
        kind = quantity_type(field.unit, field.least, field.most, field.meaning)
        if field.required:
            return kind, ...
        return (kind, field.default) if field.default is not None else (kind | None, None)
    if isinstance(field, Word):
        words: Any = Literal.__getitem__(field.words)
        return Annotated[
            words, Field(description=field.meaning)
        ], ... if field.default is None else field.default
    if isinstance(field, ObjectName):
        return Annotated[Name, Field(description=field.meaning)], ...
    place = Annotated[TargetFields, Field(description=field.meaning)]
    return (place, ...) if field.required else (place | None, None)


def _makers(gesture: Gesture) -> str:
    named = {HAND: "a hand", BOTH: "both hands", HEAD: "the head"}
    return " or ".join(named[who] for who in gesture.who)


def _record_of(name: str, gesture: Gesture) -> type[StepFields]:
    """The record of a gesture's steps."""
    fields: dict[str, Any] = {field.name: _type_of(field) for field in gesture.fields}
    fields["do"] = (Literal[name], ...)
    made: type[StepFields] = create_model(
        "".join(word.title() for word in name.split("_")),
        __base__=StepFields,
        __module__=__name__,
        __doc__=f"{_makers(gesture).capitalize()}: {gesture.meaning}.",
        **fields,
    )
    return made


RECORDS: Mapping[str, type[StepFields]] = {
    name: _record_of(name, gesture) for name, gesture in GESTURES.items()
}
# Where pickle looks for the type of a step that goes to a worker.
globals().update({record.__name__: record for record in RECORDS.values()})
if TYPE_CHECKING:
    AnyStep = StepFields
else:
    _union = None
    for _record in RECORDS.values():
        _union = _record if _union is None else _union | _record
    AnyStep = Annotated[_union, Field(discriminator="do")]


def quantities(step: StepFields) -> Iterator[Quantified]:
    """Yield all numbers of a step."""
    for name, ends in TIMES.items():
        value = getattr(step, name)
        if value is not None:
            yield name, value, "s", ends
    for field in GESTURES[step.do].fields:
        value = getattr(step, field.name)
        if value is None:
            continue
        if isinstance(field, Quantity):
            yield field.name, value, field.unit, (field.least, field.most)
        elif isinstance(field, Place):
            for part in ("table", "by"):
                for axis, length in enumerate(getattr(value, part) or ()):
                    yield f"{field.name}.{part}.{axis}", length, "m", LENGTH


def numbers_of(step: StepFields, values: Values) -> dict[str, float]:
    """The numbers that a step has, in SI units."""
    return {
        field.name: expression_of(getattr(step, field.name), field.unit).value(values)
        for field in GESTURES[step.do].fields
        if isinstance(field, Quantity) and getattr(step, field.name) is not None
    }


def words_of(step: StepFields) -> dict[str, str]:
    """Words and names of objects of a step."""
    kinds = (Word, ObjectName)
    return {
        f.name: str(getattr(step, f.name)) for f in GESTURES[step.do].fields if isinstance(f, kinds)
    }


def targets_of(step: StepFields, values: Values) -> dict[str, Target]:
    """The targets that a step has, in metres."""
    places = (f.name for f in GESTURES[step.do].fields if isinstance(f, Place))
    given = {name: getattr(step, name) for name in places}
    return {name: target_of(t, values) for name, t in given.items() if t is not None}


def target_of(target: TargetFields, values: Values) -> Target:
    """A target in metres."""
    kind = next(k for k in ("table", "object", "body") if getattr(target, k) is not None)
    offset = (target.table if kind == "table" else target.by) or ()
    along = [expression_of(length, "m").value(values) for length in offset]
    ahead, aside, up = [*along, 0.0, 0.0, 0.0][:3]
    name = "" if kind == "table" else str(getattr(target, kind))
    return Target(kind, name, (ahead, aside, up))
