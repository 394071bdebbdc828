"""What can be wrong with a script before it is played: names, hands, objects, numbers."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from scenarios.spec.motion.expression import expression_of, fault_of_expression
from scenarios.spec.motion.script import OTHER, ScriptMotion, sides_of
from scenarios.spec.motion.steps import StepFields, quantities, words_of
from scenarios.spec.parameters.choice import Choice
from scenarios.spec.suggestion import did_you_mean
from sim.families.gestures.gesture import (
    ANY_LOAD,
    BOTH,
    HAND,
    HEAD,
    LOADED,
    NO_LOAD,
    PUTS,
    TAKES,
    ObjectName,
    Place,
)
from sim.families.gestures.registry import GESTURES
from sim.pose import SIDES

MOST_CASTS = 16  # assignments of sides to parameters that are tried


@dataclass(frozen=True)
class ScriptFault:
    """A fault of a script: dotted path of the field below the scenario, and the broken rule."""

    path: str
    message: str


def script_faults(
    motion: ScriptMotion, parameters: Mapping[str, object], own: Sequence[str]
) -> Iterator[ScriptFault]:
    """Yield the faults of a script.

    parameters: of its scenario, by name; own: those of them that are not standard.
    """
    sides = side_parameters(parameters)
    for name, given in motion.objects.items():
        path = f"motion.objects.{name}"
        if given.side not in (*SIDES, *sides):
            hint = did_you_mean(given.side, (*SIDES, *sides))
            yield ScriptFault(
                f"{path}.side",
                f"must be right, left, or a parameter that is either, got {given.side!r}{hint}",
            )
        for field, value, unit, ends in given.quantities():
            fault = _number_fault(value, unit, ends, parameters)
            if fault:
                yield ScriptFault(f"{path}.{field}", fault)
    if not motion.steps:
        yield ScriptFault("motion.steps", "needs at least one step")
    earlier: dict[str, int] = {}
    for index, step in enumerate(motion.steps):
        path = f"motion.steps.{index}"
        for field, message in _step_faults(motion, step, parameters, sides, earlier):
            yield ScriptFault(f"{path}.{field}", message)
            return  # what follows may be its echo
        if step.name:
            earlier[step.name] = index
    yield from _load_faults(motion, sides)
    yield from _unused(motion, own)


def side_parameters(parameters: Mapping[str, object]) -> dict[str, Choice]:
    """The parameters that are right or left, and so can stand for a hand."""
    return {
        name: parameter
        for name, parameter in parameters.items()
        if isinstance(parameter, Choice) and {*parameter.choices} <= {*SIDES}
    }


def used_parameters(motion: ScriptMotion) -> set[str]:
    """Names of the parameters that steps and objects refer to."""
    used = {step.who.removeprefix(OTHER) for step in motion.steps}
    used |= {given.side for given in motion.objects.values()}
    numbers = itertools.chain(
        *(quantities(step) for step in motion.steps),
        *(given.quantities() for given in motion.objects.values()),
    )
    return used | {name for _, v, u, _ in numbers for _, name in expression_of(v, u).terms}


def _step_faults(
    motion: ScriptMotion,
    step: StepFields,
    parameters: Mapping[str, object],
    sides: Mapping[str, Choice],
    earlier: Mapping[str, int],
) -> Iterator[tuple[str, str]]:
    """Yield (field, message) of a step."""
    gesture = GESTURES[step.do]
    yield from _who_faults(step, sides)
    for given, name in (("after", step.after), ("with", step.along)):
        if name is not None and name not in earlier:
            listed = f"; named: {', '.join(earlier)}" if earlier else "; no step before has a name"
            hint = did_you_mean(name, earlier) or listed
            yield given, f"no earlier step is named {name!r}{hint}"
    if step.name is not None and step.name in earlier:
        yield "name", f"{step.name} is already the name of motion.steps.{earlier[step.name]}"
    if sum(value is not None for value in (step.at, step.after, step.along)) > 1:
        extra = "with" if step.along is not None else "after"
        yield extra, "give one of at, after, with"
    if step.at is not None and step.wait != 0.0:
        yield "wait", "goes with after or with, or alone; `at` is a time itself"
    if getattr(step, "speed", None) is not None and getattr(step, "duration", None) is not None:
        fields = {field.name for field in gesture.fields}
        if {"speed", "duration"} <= fields and step.do != "wave":
            yield "duration", "give speed or duration, not both"
    for field in gesture.fields:
        value = getattr(step, field.name)
        if isinstance(field, ObjectName) and value not in motion.objects:
            yield field.name, _no_object(value, motion)
        if isinstance(field, Place) and value is not None:
            if value.object is not None and value.object not in motion.objects:
                yield f"{field.name}.object", _no_object(value.object, motion)
            if value.body is not None and not field.body:
                yield f"{field.name}.body", f"{step.do} goes to the table or to an object"
    for name, number, unit, ends in quantities(step):
        fault = _number_fault(number, unit, ends, parameters)
        if fault:
            yield name, fault


def _who_faults(step: StepFields, sides: Mapping[str, Choice]) -> Iterator[tuple[str, str]]:
    makers = GESTURES[step.do].who
    named = step.who.removeprefix(OTHER)
    actor = {"both": BOTH, "head": HEAD}.get(step.who, HAND)
    if actor == HAND and named not in (*SIDES, *sides):
        known = ("right", "left", "both", "head", *sides)
        yield (
            "who",
            f"must be right, left, both, head, a parameter that is right or left, or {OTHER}and "
            f"such a parameter, got {step.who!r}{did_you_mean(named, known)}",
        )
    elif actor not in makers:
        words = {HAND: "one hand: right or left", BOTH: "both hands: both", HEAD: "the head: head"}
        makers_text = ", or ".join(words[maker] for maker in makers)
        yield "who", f"{step.do} is made by {makers_text}, got {step.who}"


def _number_fault(
    value: float | str, unit: str, ends: tuple[float, float], parameters: Mapping[str, object]
) -> str:
    def hint(name: str) -> str:
        return did_you_mean(name, list(parameters))

    return fault_of_expression(expression_of(value, unit), unit, ends, parameters, hint)


def _no_object(name: object, motion: ScriptMotion) -> str:
    known = list(motion.objects)
    listed = f"; objects: {', '.join(known)}" if known else "; motion.objects has none"
    return f"no object {str(name)!r}{did_you_mean(str(name), known) or listed}"


def _load_faults(motion: ScriptMotion, sides: Mapping[str, Choice]) -> Iterator[ScriptFault]:
    """Yield what hands cannot do with what they hold, for each assignment of sides."""
    used = {step.who.removeprefix(OTHER) for step in motion.steps} & {*sides}
    names = sorted(used)
    casts = itertools.product(*(sides[name].choices for name in names))
    for cast in itertools.islice(casts, MOST_CASTS):
        yield from _load_faults_of(motion, dict(zip(names, cast, strict=True)))


def _load_faults_of(motion: ScriptMotion, cast: Mapping[str, str]) -> Iterator[ScriptFault]:
    held: dict[int, tuple[str, int]] = {}  # side -> object, step that took it
    for index, step in enumerate(motion.steps):
        load, path = GESTURES[step.do].load, f"motion.steps.{index}"
        for side in sides_of(step.who, cast):
            hand = f"the {SIDES[side]} hand"
            if load in (TAKES, NO_LOAD) and side in held:
                name, taken = held[side]
                yield ScriptFault(
                    f"{path}.do",
                    f"{hand} already holds {name} (motion.steps.{taken}); put it down first",
                )
                return
            if load in (LOADED, PUTS) and side not in held:
                yield ScriptFault(f"{path}.do", f"{hand} holds nothing; grasp an object first")
                return
            if load == TAKES:
                name = words_of(step)["object"]
                for other, (theirs, taken) in held.items():
                    if theirs == name:
                        yield ScriptFault(
                            f"{path}.object",
                            f"the {SIDES[other]} hand holds {name} (motion.steps.{taken}); put it "
                            "down first",
                        )
                        return
                held[side] = (name, index)
            if load == PUTS:
                del held[side]
            assert load in (TAKES, NO_LOAD, LOADED, PUTS, ANY_LOAD)


def _unused(motion: ScriptMotion, own: Sequence[str]) -> Iterator[ScriptFault]:
    used = used_parameters(motion)
    for name in own:
        if name not in used:
            yield ScriptFault(
                f"parameters.{name}", "no step or object refers to it, and it is no standard one"
            )
