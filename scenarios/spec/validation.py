"""Errors of pydantic as messages with a place in the file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from pydantic import BaseModel, ValidationError

from scenarios.spec.faults import FieldPath, Position, Positions, dotted
from scenarios.spec.schema import fields_beside
from scenarios.spec.suggestion import did_you_mean
from scenarios.spec.value_text import describe_value
from sim.families.gestures.registry import GESTURES

_NAME_RULE = "must be lower-case letters, digits and _, beginning with a letter"
_LIMITS = {
    "greater_than": ("gt", "greater than"),
    "greater_than_equal": ("ge", "at least"),
    "less_than": ("lt", "less than"),
    "less_than_equal": ("le", "at most"),
}
_RULES = (
    (("float", "decimal"), "must be a number"),
    (("int",), "must be a whole number"),
    (("string_type",), "must be text"),
    (("string_pattern",), _NAME_RULE),
    (("string_too_long",), "is too long"),
    (("tuple_type", "list_type"), "must be a list"),
    (("dict_type", "model", "mapping"), "must be a mapping"),
)


@dataclass(frozen=True)
class FieldFault:
    """A fault of one field. secondary: other faults are reported before it."""

    at: Position
    message: str
    secondary: bool = False


def first_fault(
    error: ValidationError, data: Any, positions: Positions, record: type[BaseModel]
) -> FieldFault:
    """The first fault of a file in reading order. data: its values; record: its type."""
    faults = [_fault(dict(item), data, positions, record) for item in error.errors()]
    # A missing field is at its mapping's start: a fault of a field that is there comes first.
    return min(faults, key=lambda fault: (fault.secondary, fault.at))


def _fault(
    error: Mapping[str, Any], data: Any, positions: Positions, record: type[BaseModel]
) -> FieldFault:
    kind, context = str(error["type"]), error.get("ctx", {})
    location = tuple(error["loc"])
    if "at" in context:
        below = [int(name) if name.isdigit() else name for name in str(context["at"]).split(".")]
        location = (*location, *below)
    if location and location[-1] == "[key]":
        path = location[:-1]
        return FieldFault(positions.get(path, (1, 1)), f"{dotted(path)}{_NAME_RULE}")
    path, value = _path_in_file(location, data)
    missing = kind == "missing"
    if kind == "extra_forbidden":
        hint = did_you_mean(str(path[-1]), fields_beside(path, data, record))
        message = f"no such field{hint}"
    elif missing:
        path = (*path, location[-1])
        message = "is missing"
    else:
        message = _message(kind, context, value, str(error["msg"]))
        if kind == "union_tag_invalid" and (*path, "do") in positions:
            path = (*path, "do")
    placed = path
    while placed not in positions:
        placed = placed[:-1]
    # Entries that are wrong themselves do not count for pydantic: too few may be their echo.
    secondary = missing or kind == "too_short"
    return FieldFault(positions[placed], f"{dotted(path)}{message}", secondary)


def _path_in_file(location: Sequence[str | int], data: Any) -> tuple[FieldPath, Any]:
    """A pydantic location without the tags of its unions, and the value there."""
    path: list[str | int] = []
    value = data
    for name in location:
        if isinstance(value, Mapping) and name in value:
            value = value[str(name)]
        elif isinstance(value, list) and isinstance(name, int) and name < len(value):
            value = value[name]
        else:
            continue
        path.append(name)
    return tuple(path), value


def _message(kind: str, context: Mapping[str, Any], value: Any, pydantic_message: str) -> str:
    got = describe_value(value)
    if "fault" in context:
        return str(context["fault"])
    if kind in ("literal_error", "union_tag_invalid"):
        key = "expected" if kind == "literal_error" else "expected_tags"
        if kind == "union_tag_invalid" and isinstance(value, Mapping):
            # pydantic quotes the name of the field that tells which record it is.
            value = value.get(str(context["discriminator"]).strip("'"))
        listed = str(context[key]).replace("'", "").replace(" or ", ", ")
        hint = did_you_mean(str(value), listed.split(", "))
        return f"must be one of {listed}, got {describe_value(value)}{hint}"
    if kind == "union_tag_not_found":
        if "do" in str(context["discriminator"]):
            return f"needs a field do: {', '.join(GESTURES)}"
        return "needs a field kind: uniform, log-uniform, normal or fixed"
    if kind in _LIMITS:
        key, relation = _LIMITS[kind]
        return f"must be {relation} {context[key]:g}, got {got}"
    if kind == "finite_number":
        return f"must be finite, got {got}"
    for starts, rule in _RULES:
        if kind.startswith(starts):
            return f"{rule}, got {got}"
    if kind == "too_short":
        return f"needs at least {context['min_length']} of them, got {context['actual_length']}"
    if kind == "too_long":
        return f"takes at most {context['max_length']} of them, got {context['actual_length']}"
    return f"{pydantic_message[:1].lower()}{pydantic_message[1:]}, got {got}"
