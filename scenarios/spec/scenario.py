"""A scenario: every number a named parameter with unit, range and nominal distribution.

A *logical* scenario is the record below; `scenarios.spec.draw` turns it, with a seed, into values
and these into a `sim.script.Performance`.
"""

from __future__ import annotations

import hashlib
import json
from typing import Annotated, Literal, Self

from pydantic import BaseModel, Field, model_validator

from scenarios.spec.motion.checks import script_faults
from scenarios.spec.motion.kinds import AnyMotion
from scenarios.spec.motion.plugged import PluggedMotion
from scenarios.spec.motion.script import ScriptMotion
from scenarios.spec.parameters.choice import Choice
from scenarios.spec.parameters.file import File
from scenarios.spec.parameters.numeric import Numeric
from scenarios.spec.parameters.parameter import Parameter
from scenarios.spec.parameters.record import Name, Number, Record, Text, Whole, fault_at
from scenarios.spec.parameters.units import UNITS
from scenarios.spec.suggestion import did_you_mean
from scenarios.spec.surroundings import (
    NOMINAL,
    ROOM_CHOICES,
    ROOM_PARAMETERS,
    ROOM_RANGES,
    VARIED,
    standard_parameters,
)
from sim.motion.stage import Family

MAX_FRAMES = 20_000


def _is_nominal(surroundings: str) -> bool:
    return surroundings == NOMINAL


# Left out of a record's JSON where nominal, so that digests of nominal scenarios stay.
SurroundingsKind = Annotated[Literal["nominal", "varied"], Field(exclude_if=_is_nominal)]


class Scenario(Record):
    """A logical scenario.

    family: the name of the random streams that draw its values (`stream` in Python); twins share
    it, and so their draws. twins: scenarios that are drawn again together with this one. rates: it
    is played once at each of these frame rates, the same motion for the same time. surroundings:
    varied draws room, light, rig and person from the seed over their whole ranges. rooms: the name
    of the random streams that draw them ("" for the scenario's own name), so that twins, which
    share their motion, and two entries of a suite, share no room.
    """

    name: Name
    version: Annotated[Whole, Field(ge=1)] = 1
    group: Name
    summary: Text
    thesis: Text | None = None
    stream: Annotated[Name, Field(alias="family")]
    fps: Annotated[Number, Field(ge=1, le=30)] = 3.0
    frames: Annotated[Whole, Field(ge=1, le=MAX_FRAMES)]
    rates: tuple[Annotated[Number, Field(ge=1, le=30)], ...] = ()
    background_frames: Annotated[Whole, Field(ge=0, le=500)] = 10
    twins: tuple[Name, ...] = ()
    surroundings: SurroundingsKind = "nominal"
    rooms: Annotated[Text, Field(max_length=200, exclude_if=lambda name: not name)] = ""
    motion: AnyMotion
    parameters: dict[Name, Parameter]

    @model_validator(mode="after")
    def _complete(self) -> Self:
        """The standard parameters are added; a family's own must be there, and no others."""
        if isinstance(self.motion, ScriptMotion):
            self._refuse_faulty_script(self.motion)
        if isinstance(self.motion, PluggedMotion):
            self._take_declared(self.motion)
        own = self.motion_family.parameters
        standard = standard_parameters(self.surroundings)
        if self.rooms and self.surroundings != VARIED:
            raise fault_at("goes with `surroundings: varied`", "rooms")
        for name in self.parameters:
            if name in ROOM_PARAMETERS and name not in standard:
                raise fault_at("goes with `surroundings: varied`", f"parameters.{name}")
            if name not in own and name not in standard:
                hint = did_you_mean(name, (*own, *standard))
                raise fault_at(
                    f"{self.motion.kind} has no such parameter{hint}", f"parameters.{name}"
                )
        for name in own:
            if name not in self.parameters:
                raise fault_at(f"{self.motion.kind} needs the parameter {name}", "parameters")
        for name, parameter in self.parameters.items():
            if name in standard:
                _refuse_unfit(name, parameter, standard[name])
        merged = dict(standard) | self.parameters
        object.__setattr__(self, "parameters", merged)
        return self

    def _refuse_faulty_script(self, motion: ScriptMotion) -> None:
        """Raise the first fault of a script."""
        known = {**standard_parameters(self.surroundings), **self.parameters}
        for fault in script_faults(motion, known, self._own_names):
            raise fault_at(fault.message, fault.path)

    def _take_declared(self, motion: PluggedMotion) -> None:
        """Take the parameters that a plug-in declares where the file gives no others."""
        declared = motion.declared()
        for name in declared:
            if name in standard_parameters(self.surroundings):
                raise fault_at(
                    f"{motion.kind} declares {name}, the name of a standard parameter",
                    "motion.kind",
                )
        object.__setattr__(self, "parameters", declared | self.parameters)

    @property
    def motion_family(self) -> Family:
        """The family of motion that plays it."""
        return self.motion.family(self._own_names)

    @property
    def _own_names(self) -> tuple[str, ...]:
        """Names of the parameters that are not standard ones."""
        standard = standard_parameters(self.surroundings)
        return tuple(name for name in self.parameters if name not in standard)


def _refuse_unfit(name: str, parameter: Parameter, usual: Numeric | Choice) -> None:
    """Raise the fault of a parameter that cannot stand in for the usual one of its name."""
    at = f"parameters.{name}"
    if isinstance(parameter, File):
        raise fault_at("cannot be a file", f"{at}.file")
    if isinstance(parameter, Choice):
        known = ROOM_CHOICES.get(name, parameter.choices)
        for option in parameter.choices:
            if option not in known:
                hint = did_you_mean(option, known)
                raise fault_at(
                    f"must be among {', '.join(known)}, got {option!r}{hint}", f"{at}.choices"
                )
        return
    if isinstance(usual, Numeric) and UNITS[parameter.unit] != UNITS[usual.unit]:
        raise fault_at(f"unit must be {usual.unit}", f"{at}.unit")
    ends = ROOM_RANGES.get(name)
    if ends and not ends[0] <= parameter.range[0] <= parameter.range[1] <= ends[1]:
        raise fault_at(f"must lie within {ends[0]:g} to {ends[1]:g}", f"{at}.range")


def in_varied_surroundings(scenario: Scenario, rooms: str) -> Scenario:
    """The scenario with the same motion in varied surroundings, drawn by streams of this name.

    Parameters that it gives itself stay as they are.
    """
    usual = standard_parameters(scenario.surroundings)
    own = {name: p for name, p in scenario.parameters.items() if usual.get(name) != p}
    merged = dict(standard_parameters(VARIED)) | own
    update = {"surroundings": VARIED, "rooms": rooms, "parameters": merged}
    return scenario.model_copy(update=update)


def canonical(record: BaseModel) -> str:
    """The unique JSON text of a record: sorted keys, no spaces."""
    return json.dumps(record.model_dump(mode="json"), sort_keys=True, separators=(",", ":"))


def digest(scenario: Scenario) -> str:
    """SHA-256 of the canonical JSON of a scenario, hexadecimal; of a file, its content counts."""
    return hashlib.sha256(canonical(scenario).encode()).hexdigest()
