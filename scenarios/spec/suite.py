"""A suite: an ordered list of scenarios to play."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from typing import Annotated

from pydantic import Field, Strict, ValidationInfo, field_serializer, field_validator

from scenarios.spec.parameters.file import contents, file_in_context
from scenarios.spec.parameters.record import Name, Record, Text, Whole
from scenarios.spec.scenario import (
    MAX_FRAMES,
    Scenario,
    SurroundingsKind,
    canonical,
    digest,
)
from sim.clips.clip_files import SUFFIXES


class SuiteEntry(Record):
    """A scenario of a suite, the values that are changed in it, and its name in the results.

    A text among the overrides that ends as a clip does (no unit and no choice does) is a file,
    below the suite's folder.
    """

    scenario: Text
    label: Annotated[str, Strict(), Field(pattern=r"^[a-z][a-z0-9_.@+-]*$", max_length=60)] = ""
    frames: Annotated[Whole, Field(ge=1, le=MAX_FRAMES)] | None = None
    seeds: Annotated[Whole, Field(ge=1, le=100_000)] | None = None
    overrides: dict[Name, Annotated[float, Strict()] | Text] = Field(default_factory=dict)

    @field_validator("overrides")
    @classmethod
    def _with_files(
        cls, overrides: dict[str, float | str], info: ValidationInfo
    ) -> dict[str, float | str]:
        return {
            name: file_in_context(value, info, at=name)
            if isinstance(value, str) and value.lower().endswith(SUFFIXES)
            else value
            for name, value in overrides.items()
        }

    @field_serializer("overrides", when_used="json")
    def _contents(self, overrides: dict[str, float | str]) -> dict[str, float | str]:
        return contents(overrides)


class Suite(Record):
    """An ordered list of scenarios. seeds: episodes of each entry that gives no number itself.

    surroundings: varied plays every entry in rooms of its own.
    """

    name: Name
    version: Annotated[Whole, Field(ge=1)] = 1
    summary: Text
    seeds: Annotated[Whole, Field(ge=1, le=100_000)] = 1
    surroundings: SurroundingsKind = "nominal"
    scenarios: Annotated[tuple[SuiteEntry, ...], Field(min_length=1)]


def suite_digest(suite: Suite, scenarios: Mapping[str, Scenario]) -> str:
    """SHA-256 of a suite and of the scenarios (by name) that it lists, hexadecimal."""
    texts = [canonical(suite), *(digest(scenarios[e.scenario]) for e in suite.scenarios)]
    return hashlib.sha256("\n".join(texts).encode()).hexdigest()
