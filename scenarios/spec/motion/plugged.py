"""A motion that a plug-in plays: the kind of motion of a user's, by name."""

from __future__ import annotations

import os
import re
from typing import Annotated, Any, Self

from pydantic import BeforeValidator, Field, TypeAdapter, ValidationError, model_validator

from pjpdaf.errors import BenchError
from pjpdaf.plugins.loading import allow_plug_ins_from_here, entry_point_names
from scenarios.spec.parameters.parameter import Parameter
from scenarios.spec.parameters.record import NAME, Record, Text, fault_at
from sim.families.plugged import MOTIONS, own_family, own_motion, source_digest
from sim.motion.stage import Family

TRUSTED_VARIABLE = "PJPDAF_BENCH_MOTIONS"
MODULE_FACTORY = re.compile(r"[A-Za-z_][\w.]*:[A-Za-z_]\w*", re.ASCII)
_PARAMETER: TypeAdapter[Parameter] = TypeAdapter(Parameter)


def is_code(name: str) -> bool:
    """Whether a name is that of code that is not installed: module:factory."""
    return ":" in name


def trust(*names: str) -> None:
    """Let files and workers load the module:factory among names, because the user has named it.

    It may lie in the current folder.
    """
    for name in names:
        if MODULE_FACTORY.fullmatch(name) and name not in _trusted():
            os.environ[TRUSTED_VARIABLE] = ",".join([*sorted(_trusted()), name])
            allow_plug_ins_from_here(name)


def _trusted() -> set[str]:
    named = os.environ.get(TRUSTED_VARIABLE, "").split(",")
    return {name.strip() for name in named} - {""}


def fault_of_name(name: str) -> str:
    """Why the user must first say that they trust a module:factory, or ""; it is code."""
    if not is_code(name) or name in _trusted():
        return ""
    if MODULE_FACTORY.fullmatch(name) is None:
        return f"must be written module:factory, got {name[:60]!r}"
    return (
        f"{name} is code, and a file alone does not start code; to trust it set "
        f"{TRUSTED_VARIABLE}={name}"
    )


def _trusted_kind(name: object) -> object:
    if isinstance(name, str):
        if fault := fault_of_name(name):
            raise fault_at(fault)
        allow_plug_ins_from_here(name)
    return name


class PluggedMotion(Record):
    """A motion that a plug-in plays: an entry point, or module:factory that the user trusts.

    source: SHA-256 of its module or package, part of the scenario's digest.
    """

    kind: Annotated[
        Text,
        BeforeValidator(_trusted_kind),
        Field(
            max_length=200, description="entry point of pjpdaf_bench.families, or module:factory"
        ),
    ]
    source: Text = ""

    @model_validator(mode="after")
    def _loads(self) -> Self:
        """It is there, its parameters are sound, and it is still the one of the digest."""
        now = source_digest(self.kind)
        if self.source and self.source != now:
            raise fault_at(f"{self.kind} has changed since this was written", "source")
        object.__setattr__(self, "source", now)
        try:
            self.declared()
        except BenchError as fault:
            raise fault_at(str(fault), "kind") from None
        return self

    def family(self, parameters: tuple[str, ...]) -> Family:
        """The family of the plug-in, whatever the parameters."""
        return own_family(self.kind)

    def declared(self) -> dict[str, Parameter]:
        """The parameters that it declares. Raises BenchError for one that is faulty."""
        return declared_parameters(self.kind)


def declared_parameters(name: str) -> dict[str, Parameter]:
    """The parameters that a plug-in declares. Raises BenchError for one that is faulty."""
    declared: dict[str, Parameter] = {}
    for parameter, given in own_motion(name).parameters.items():
        where = f"The motion {name!r}: the parameter {parameter!r}"
        if not isinstance(parameter, str) or re.fullmatch(NAME, parameter) is None:
            raise BenchError(f"{where} must be lower-case letters, digits and _.")
        try:
            declared[parameter] = _PARAMETER.validate_python(given)
        except ValidationError as fault:
            raise BenchError(f"{where}: {first_line(fault.errors()[0])}") from None
        if not declared[parameter].meaning:
            raise BenchError(f"{where}: needs a meaning.")
    return declared


def first_line(error: Any) -> str:
    """A fault of pydantic's in one line: the place in what the plug-in declares, then the rule."""
    place = ".".join(str(part) for part in error["loc"] if part not in ("numeric", "choice"))
    text = str(error.get("ctx", {}).get("fault", error["msg"]))
    return f"{place}: {text}." if place else f"{text}."


def is_plugged(kind: object) -> bool:
    """Whether the kind of a motion is a plug-in's, by its form or among the entry points."""
    return isinstance(kind, str) and (is_code(kind) or kind in entry_point_names(MOTIONS))
