"""The kinds of motion that a scenario can name, and the family that plays each."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import Discriminator, Field, Tag, field_validator

from scenarios.spec.motion.plugged import PluggedMotion, is_plugged
from scenarios.spec.motion.script import ScriptMotion
from scenarios.spec.parameters.record import Name, Record, fault_at
from scenarios.spec.suggestion import did_you_mean
from sim.families.registry import FAMILIES
from sim.motion.stage import Family

SCRIPT = "script"
KINDS = (*FAMILIES, SCRIPT)


class Motion(Record):
    """Which family of motion plays the parameters."""

    kind: Annotated[Name, Field(json_schema_extra={"enum": list(FAMILIES)})]

    @field_validator("kind")
    @classmethod
    def _known(cls, kind: str) -> str:
        if kind not in FAMILIES:
            known, hint = ", ".join(KINDS), did_you_mean(kind, KINDS)
            raise fault_at(f"must be one of {known}, got {kind!r}{hint}")
        return kind

    def family(self, parameters: tuple[str, ...]) -> Family:
        """The family of this name, whatever the parameters."""
        return FAMILIES[self.kind]


def _tag_of(data: Any) -> str:
    kind = data.get("kind") if isinstance(data, Mapping) else getattr(data, "kind", None)
    # No possible names of fields: places of faults carry the tag.
    if kind == SCRIPT:
        return "a script"
    return "of a plug-in" if kind not in KINDS and is_plugged(kind) else "of ours"


AnyMotion = Annotated[
    Annotated[Motion, Tag("of ours")]
    | Annotated[ScriptMotion, Tag("a script")]
    | Annotated[PluggedMotion, Tag("of a plug-in")],
    Discriminator(_tag_of),
]
