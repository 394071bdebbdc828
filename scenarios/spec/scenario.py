"""A scenario: every number a named parameter with unit, range and nominal distribution.

A *logical* scenario is the record below; `scenarios.spec.draw` turns it, with a seed, into values
and these into a `sim.script.Performance`.
"""

from __future__ import annotations

import hashlib
import json
from typing import Annotated, Self

from pydantic import BaseModel, Field, model_validator

from scenarios.spec.motion.checks import script_faults
from scenarios.spec.motion.kinds import AnyMotion
from scenarios.spec.motion.script import ScriptMotion
from scenarios.spec.parameters.file import File
from scenarios.spec.parameters.numeric import Numeric
from scenarios.spec.parameters.parameter import Parameter
from scenarios.spec.parameters.record import Name, Number, Record, Text, Whole, fault_at
from scenarios.spec.parameters.units import UNITS
from scenarios.spec.standard import STANDARD
from scenarios.spec.suggestion import did_you_mean
from sim.motion.stage import Family

MAX_FRAMES = 20_000


class Scenario(Record):
    """A logical scenario.

    family: the name of the random streams that draw its values (`stream` in Python); twins share
    it, and so their draws. twins: scenarios that are drawn again together with this one. rates: it
    is played once at each of these frame rates, the same motion for the same time.
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
    motion: AnyMotion
    parameters: dict[Name, Parameter]

    @model_validator(mode="after")
    def _complete(self) -> Self:
        """The standard parameters are added; a family's own must be there, and no others."""
        if isinstance(self.motion, ScriptMotion):
            self._refuse_faulty_script(self.motion)
        own = self.motion_family.parameters
        for name in self.parameters:
            if name not in own and name not in STANDARD:
                hint = did_you_mean(name, (*own, *STANDARD))
                raise fault_at(
                    f"{self.motion.kind} has no such parameter{hint}", f"parameters.{name}"
                )
        for name in own:
            if name not in self.parameters:
                raise fault_at(f"{self.motion.kind} needs the parameter {name}", "parameters")
        for name, parameter in self.parameters.items():
            if name in STANDARD and isinstance(parameter, File):
                raise fault_at("cannot be a file", f"parameters.{name}.file")
            if name in STANDARD and isinstance(parameter, Numeric):
                usual = STANDARD[name]
                if isinstance(usual, Numeric) and UNITS[parameter.unit] != UNITS[usual.unit]:
                    raise fault_at(f"unit must be {usual.unit}", f"parameters.{name}.unit")
        merged = dict(STANDARD) | self.parameters
        object.__setattr__(self, "parameters", merged)
        return self

    def _refuse_faulty_script(self, motion: ScriptMotion) -> None:
        """Raise the first fault of a script."""
        own = [name for name in self.parameters if name not in STANDARD]
        for fault in script_faults(motion, {**STANDARD, **self.parameters}, own):
            raise fault_at(fault.message, fault.path)

    @property
    def motion_family(self) -> Family:
        """The family of motion that plays it."""
        return self.motion.family(tuple(n for n in self.parameters if n not in STANDARD))


def canonical(record: BaseModel) -> str:
    """The unique JSON text of a record: sorted keys, no spaces."""
    return json.dumps(record.model_dump(mode="json"), sort_keys=True, separators=(",", ":"))


def digest(scenario: Scenario) -> str:
    """SHA-256 of the canonical JSON of a scenario, hexadecimal; of a file, its content counts."""
    return hashlib.sha256(canonical(scenario).encode()).hexdigest()
