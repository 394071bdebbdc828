"""A scenario: every number a named parameter with unit, range and nominal distribution.

A *logical* scenario is the record below; `scenarios.spec.draw` turns it, with a seed, into values
and these into a `sim.script.Performance`.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from typing import Annotated, Self

from pydantic import (
    BaseModel,
    Field,
    Strict,
    ValidationInfo,
    field_serializer,
    field_validator,
    model_validator,
)
from pydantic_core import PydanticCustomError

from scenarios.spec.parameters import (
    UNITS,
    File,
    FileText,
    Name,
    Number,
    Numeric,
    Parameter,
    Record,
    Text,
    Whole,
    fault_at,
    found_file,
    nearest,
)
from scenarios.spec.standard import STANDARD
from sim.clips.clip_files import SUFFIXES
from sim.families.registry import FAMILIES
from sim.motion.stage import Value

MAX_FRAMES = 20_000


class Motion(Record):
    """Which family of motion plays the parameters."""

    kind: Annotated[Name, Field(json_schema_extra={"enum": list(FAMILIES)})]

    @field_validator("kind")
    @classmethod
    def _known(cls, kind: str) -> str:
        if kind not in FAMILIES:
            known, hint = ", ".join(FAMILIES), nearest(kind, FAMILIES)
            fault = f"must be one of {known}, got {kind!r}{hint}"
            raise PydanticCustomError("kind", "{fault}", {"fault": fault})
        return kind


class Scenario(Record):
    """A logical scenario.

    family: names its random streams; twins share one, and their draws. twins: scenarios that are
    drawn again together with this one. rates: it is played once at each of these frame rates, the
    same motion for the same time.
    """

    name: Name
    version: Annotated[Whole, Field(ge=1)] = 1
    group: Name
    summary: Text
    thesis: Text | None = None
    family: Name
    fps: Annotated[Number, Field(ge=1, le=30)] = 3.0
    frames: Annotated[Whole, Field(ge=1, le=MAX_FRAMES)]
    rates: tuple[Annotated[Number, Field(ge=1, le=30)], ...] = ()
    background_frames: Annotated[Whole, Field(ge=0, le=500)] = 10
    twins: tuple[Name, ...] = ()
    motion: Motion
    parameters: dict[Name, Parameter]

    @model_validator(mode="after")
    def _complete(self) -> Self:
        """The standard parameters are added; a family's own must be there, and no others."""
        own = FAMILIES[self.motion.kind].parameters
        for name in self.parameters:
            if name not in own and name not in STANDARD:
                hint = nearest(name, (*own, *STANDARD))
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


def canonical(record: BaseModel) -> str:
    """The one JSON text of a record: sorted keys, no spaces."""
    return json.dumps(record.model_dump(mode="json"), sort_keys=True, separators=(",", ":"))


def contents(values: Mapping[str, Value]) -> dict[str, Value]:
    """The same values with, for each file, its content instead of its name."""
    return {
        name: f"sha256:{value.sha256}" if isinstance(value, FileText) else value
        for name, value in values.items()
    }


def digest(scenario: Scenario) -> str:
    """SHA-256 of the canonical JSON of a scenario, hexadecimal; of a file, its content counts."""
    return hashlib.sha256(canonical(scenario).encode()).hexdigest()


class Entry(Record):
    """One line of a suite: a scenario, what to change of it, and its name in the results.

    A text of overrides that ends as a clip does (no unit and no choice does) is a file, below the
    suite's folder.
    """

    scenario: Text
    label: Annotated[str, Strict(), Field(pattern=r"^[a-z][a-z0-9_.@+-]*$", max_length=60)] = ""
    frames: Annotated[Whole, Field(ge=1, le=MAX_FRAMES)] | None = None
    seeds: Annotated[Whole, Field(ge=1, le=100_000)] | None = None
    overrides: dict[Name, Annotated[float, Strict()] | Text] = Field(default_factory=dict)

    @field_validator("overrides")
    @classmethod
    def _found(
        cls, overrides: dict[str, float | str], info: ValidationInfo
    ) -> dict[str, float | str]:
        found = dict(overrides)
        for name, value in overrides.items():
            if isinstance(value, str) and value.lower().endswith(SUFFIXES):
                found[name] = found_file(value, info, at=name)
        return found

    @field_serializer("overrides", when_used="json")
    def _contents(self, overrides: dict[str, float | str]) -> dict[str, float | str]:
        return contents(overrides)


class Suite(Record):
    """An ordered list of scenarios. `seeds`: how many each plays unless its entry says."""

    name: Name
    version: Annotated[Whole, Field(ge=1)] = 1
    summary: Text
    seeds: Annotated[Whole, Field(ge=1, le=100_000)] = 1
    scenarios: Annotated[tuple[Entry, ...], Field(min_length=1)]


def suite_digest(suite: Suite, scenarios: Mapping[str, Scenario]) -> str:
    """SHA-256 of a suite and of the scenarios (by name) that it lists, hexadecimal."""
    parts = [canonical(suite), *(digest(scenarios[e.scenario]) for e in suite.scenarios)]
    return hashlib.sha256("\n".join(parts).encode()).hexdigest()
