"""Scenario and suite files: YAML in, records out, every fault one line with its place."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError
from ruamel.yaml import YAML
from ruamel.yaml.error import MarkedYAMLError, YAMLError
from ruamel.yaml.events import AliasEvent, CollectionEndEvent, CollectionStartEvent, NodeEvent
from ruamel.yaml.nodes import MappingNode, Node, ScalarNode, SequenceNode

from pjpdaf.errors import BenchError
from scenarios.spec.parameters import nearest
from scenarios.spec.scenario import Scenario, Suite

MAX_BYTES = 1 << 20
MAX_DEPTH = 30
_PACKAGE = Path(__file__).parents[1]
_SORTS = {"file": "File", "choices": "Choice"}  # the field that tells a sort of parameter
_TAG = "tag:yaml.org,2002:"

Path_ = tuple[str | int, ...]
Positions = dict[Path_, tuple[int, int]]  # (line, column), from 1: of the key, or of a list's item
R = TypeVar("R", bound=BaseModel)


class FileFault(BenchError):
    """What is wrong with a file, and where: `file:line:column: path: rule`."""

    def __init__(self, file: str, at: tuple[int, int] | None, message: str) -> None:
        where = file if at is None else f"{file}:{at[0]}:{at[1]}"
        # What is quoted from the file may hold anything; a fault stays one line.
        plain = "".join(c if c.isprintable() else "?" for c in f"{where}: {message}")
        super().__init__(plain)


def load_scenario_file(path: Path | str) -> Scenario:
    """The scenario of a YAML file. Raises BenchError with the place of the first fault."""
    return parse(read_text(path), str(path), Scenario, Path(path).parent)


def load_suite_file(path: Path | str) -> Suite:
    """The suite of a YAML file. Raises BenchError with the place of the first fault."""
    return parse(read_text(path), str(path), Suite, Path(path).parent)


def load_either_file(path: Path | str) -> Scenario | Suite:
    """The scenario, or the suite (a file with a field `scenarios`), of a YAML file."""
    text = read_text(path)
    data, _ = _data_of(text, str(path))
    if isinstance(data, dict) and "scenarios" in data:
        return parse(text, str(path), Suite, Path(path).parent)
    return parse(text, str(path), Scenario, Path(path).parent)


def json_schema() -> dict[str, Any]:
    """The JSON schema of a scenario file, for editors."""
    schema = Scenario.model_json_schema()
    schema["$schema"] = "https://json-schema.org/draft/2020-12/schema"
    # Numbers may also be text with a unit; editors should not mark that.
    quantity = {"anyOf": [{"type": "number"}, {"type": "string"}]}
    definitions = schema.get("$defs", {})
    for name in ("Uniform", "LogUniform", "Normal", "Fixed"):
        for key, field in definitions[name]["properties"].items():
            if key != "kind":
                definitions[name]["properties"][key] = quantity | {"title": field.get("title", key)}
    definitions["Numeric"]["properties"]["range"]["prefixItems"] = [quantity, quantity]
    return schema


def read_text(path: Path | str) -> str:
    """A file's text. Raises BenchError if it is missing, a folder, too large or not UTF-8."""
    file = Path(path)
    try:
        if file.is_dir():
            raise FileFault(str(path), None, "is a folder, not a file")
        with file.open("rb") as stream:
            data = stream.read(MAX_BYTES + 1)
    except FileNotFoundError:
        raise FileFault(str(path), None, "no such file") from None
    except (OSError, ValueError) as fault:
        reason = getattr(fault, "strerror", None) or str(fault)
        raise FileFault(str(path), None, f"cannot be read: {reason.lower()}") from None
    if len(data) > MAX_BYTES:
        raise FileFault(str(path), None, f"is larger than {MAX_BYTES >> 20} MiB")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as fault:
        line = data.count(b"\n", 0, fault.start) + 1
        column = fault.start - (data.rfind(b"\n", 0, fault.start) + 1) + 1
        raise FileFault(str(path), (line, column), "is not UTF-8 text") from None


def parse(text: str, file: str, record: type[R], folder: Path | None = None) -> R:
    """A record of YAML text; `file` names it in faults.

    folder: where the files that it names lie. None: the text is a shipped one, and `file` its name
    below this package.
    """
    if folder is None:
        folder = (_PACKAGE / file).parent
    data, positions = _data_of(text, file)
    if not isinstance(data, dict):
        raise FileFault(file, (1, 1), f"must be a mapping of fields, got {_kind(data)}")
    try:
        return record.model_validate(data, context={"folder": folder})
    except ValidationError as fault:
        places = [
            _place_and_words(dict(error), data, positions, record) for error in fault.errors()
        ]
        # A missing field is at its mapping's start: a fault of what is there comes first.
        at, message, _ = min(places, key=lambda place: (place[2], place[0]))
        raise FileFault(file, at, message) from None


# --- YAML ----------------------------------------------------------------------------------------


def _data_of(text: str, file: str) -> tuple[Any, Positions]:
    yaml = YAML(typ="safe", pure=True)
    try:
        depth = 0
        for event in yaml.parse(text):
            mark = event.start_mark
            at = (mark.line + 1, mark.column + 1)
            if isinstance(event, AliasEvent) or (isinstance(event, NodeEvent) and event.anchor):
                raise FileFault(file, at, "anchors and aliases (& and *) are not allowed")
            depth += isinstance(event, CollectionStartEvent)
            depth -= isinstance(event, CollectionEndEvent)
            if depth > MAX_DEPTH:
                raise FileFault(file, at, f"is nested deeper than {MAX_DEPTH} levels")
        node = YAML(typ="safe", pure=True).compose(text)
    except MarkedYAMLError as fault:
        mark = fault.problem_mark or fault.context_mark
        found = None if mark is None else (mark.line + 1, mark.column + 1)
        problem = (fault.problem or "cannot be read").splitlines()[0]
        raise FileFault(file, found, f"is not YAML: {problem}") from None
    except (YAMLError, RecursionError) as fault:
        problem = (str(fault) or "nested too deeply").splitlines()[0]
        raise FileFault(file, None, f"is not YAML: {problem}") from None
    positions: Positions = {}
    if node is None:
        return None, positions
    positions[()] = (node.start_mark.line + 1, node.start_mark.column + 1)
    return _value(node, (), positions, file), positions


def _value(node: Node, path: Path_, positions: Positions, file: str) -> Any:
    at = (node.start_mark.line + 1, node.start_mark.column + 1)
    if isinstance(node, MappingNode):
        _expect_tag(node, "map", at, path, file)
        mapping: dict[str, Any] = {}
        for key_node, value_node in node.value:
            key_at = (key_node.start_mark.line + 1, key_node.start_mark.column + 1)
            if not isinstance(key_node, ScalarNode):
                raise FileFault(file, key_at, f"{_dotted(path)}a field's name must be a word")
            key = key_node.value
            if key in mapping:
                raise FileFault(file, key_at, f"{_dotted((*path, key))}is given twice")
            positions[(*path, key)] = key_at
            mapping[key] = _value(value_node, (*path, key), positions, file)
        return mapping
    if isinstance(node, SequenceNode):
        _expect_tag(node, "seq", at, path, file)
        items = []
        for index, item in enumerate(node.value):
            positions[(*path, index)] = (item.start_mark.line + 1, item.start_mark.column + 1)
            items.append(_value(item, (*path, index), positions, file))
        return items
    return _scalar(node, path, at, file)


def _expect_tag(node: Node, kind: str, at: tuple[int, int], path: Path_, file: str) -> None:
    if str(node.tag) != _TAG + kind:
        raise FileFault(file, at, f"{_dotted(path)}tags are not allowed, got {str(node.tag)[:60]}")


def _scalar(node: ScalarNode, path: Path_, at: tuple[int, int], file: str) -> Any:
    tag, text = str(node.tag), str(node.value)
    if not tag.startswith(_TAG):
        raise FileFault(file, at, f"{_dotted(path)}tags are not allowed, got {tag[:60]}")
    kind = tag[len(_TAG) :]
    try:
        if kind == "int":
            plain = text.replace("_", "")
            return int(plain, 0) if plain.lstrip("+-").lower()[:2] in ("0x", "0o") else int(plain)
        if kind == "float":
            plain = text.replace("_", "").lower()
            return float(plain.replace(".inf", "inf").replace(".nan", "nan"))
    except (ValueError, OverflowError):
        raise FileFault(file, at, f"{_dotted(path)}cannot be read as a number") from None
    if kind == "bool":
        return text.lower() == "true"
    if kind == "null":
        return None
    if kind in ("str", "timestamp"):
        return text
    raise FileFault(file, at, f"{_dotted(path)}tags are not allowed, got !!{kind[:60]}")


# --- faults --------------------------------------------------------------------------------------


def _dotted(path: Sequence[str | int]) -> str:
    return ".".join(str(part)[:60] for part in path) + ": " if path else ""


def _kind(value: Any) -> str:
    if value is None:
        return "nothing"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float) and not math.isfinite(value):
        return str(value)
    if isinstance(value, dict):
        return "a mapping"
    if isinstance(value, list):
        return "a list"
    shown = repr(value) if isinstance(value, str) else str(value)
    return shown if len(shown) <= 60 else shown[:57] + "..."


def _known_path(location: Sequence[str | int], data: Any) -> tuple[Path_, Any]:
    """The parts of a pydantic location that are in the file: without the tags of its unions."""
    path: list[str | int] = []
    value = data
    for part in location:
        if isinstance(value, Mapping) and part in value:
            value = value[str(part)]
        elif isinstance(value, list) and isinstance(part, int) and part < len(value):
            value = value[part]
        else:
            continue
        path.append(part)
    return tuple(path), value


def _fields_near(path: Path_, data: Any, record: type[BaseModel]) -> list[str]:
    """Names of the fields that may stand beside the last part of a path."""
    parts = [str(p) for p in path[:-1]]
    schema: Mapping[str, Any] = record.model_json_schema()
    definitions = schema.get("$defs", {})
    if not parts:
        return list(schema["properties"])
    if parts[0] == "parameters" and record is Scenario:
        if len(parts) == 2:
            siblings = data["parameters"][parts[1]]
            sort = next((s for f, s in _SORTS.items() if f in siblings), "Numeric")
            return list(definitions[sort]["properties"])
        if len(parts) == 3:
            kind = data["parameters"][parts[1]]["nominal"].get("kind")
            for name in ("Uniform", "LogUniform", "Normal", "Fixed"):
                properties = definitions[name]["properties"]
                if properties["kind"]["const"] == kind:
                    return list(properties)
    if parts[0] == "motion":
        return list(definitions["Motion"]["properties"])
    if parts[0] == "scenarios":
        return list(definitions["Entry"]["properties"])
    return []


def _place_and_words(
    error: Mapping[str, Any], data: Any, positions: Positions, record: type[BaseModel]
) -> tuple[tuple[int, int], str, bool]:
    """Where a pydantic error is, in words, and whether other faults come first."""
    kind, context = str(error["type"]), error.get("ctx", {})
    location = tuple(error["loc"])
    if "at" in context:
        below = [int(p) if p.isdigit() else p for p in str(context["at"]).split(".")]
        location = (*location, *below)
    if location and location[-1] == "[key]":
        path = location[:-1]
        message = "must be lower-case letters, digits and _, beginning with a letter"
        return positions.get(path, (1, 1)), f"{_dotted(path)}{message}", False
    path, value = _known_path(location, data)
    missing = kind == "missing"
    if kind == "extra_forbidden":
        hint = nearest(str(path[-1]), _fields_near(path, data, record))
        message = f"no such field{hint}"
    elif missing:
        path = (*path, location[-1])
        message = "is missing"
    else:
        message = _words(kind, context, value, error)
    at = path
    while at not in positions:
        at = at[:-1]
    # Entries that are wrong themselves do not count for pydantic: too few may be their echo.
    return positions[at], f"{_dotted(path)}{message}", missing or kind == "too_short"


def _words(kind: str, context: Mapping[str, Any], value: Any, error: Mapping[str, Any]) -> str:
    got = _kind(value)
    if "fault" in context:
        return str(context["fault"])
    if kind in ("literal_error", "union_tag_invalid"):
        key = "expected" if kind == "literal_error" else "expected_tags"
        if kind == "union_tag_invalid" and isinstance(value, Mapping):
            value = value.get("kind")
        listed = str(context[key]).replace("'", "").replace(" or ", ", ")
        return (
            f"must be one of {listed}, got {_kind(value)}{nearest(str(value), listed.split(', '))}"
        )
    if kind == "union_tag_not_found":
        return "needs a field kind: uniform, log-uniform, normal or fixed"
    limits = {
        "greater_than": ("gt", "greater than"),
        "greater_than_equal": ("ge", "at least"),
        "less_than": ("lt", "less than"),
        "less_than_equal": ("le", "at most"),
    }
    if kind in limits:
        key, words = limits[kind]
        return f"must be {words} {context[key]:g}, got {got}"
    if kind == "finite_number":
        return f"must be finite, got {got}"
    rules = (
        (("float", "decimal"), "must be a number"),
        (("int",), "must be a whole number"),
        (("string_type",), "must be text"),
        (("string_pattern",), "must be lower-case letters, digits and _, beginning with a letter"),
        (("string_too_long",), "is too long"),
        (("tuple_type", "list_type"), "must be a list"),
        (("dict", "model", "mapping"), "must be a mapping"),
    )
    for starts, rule in rules:
        if kind.startswith(starts):
            return f"{rule}, got {got}"
    if kind == "too_short":
        return f"needs at least {context['min_length']} of them, got {got}"
    if kind == "too_long":
        return f"takes {context['max_length']} of them, got {context['actual_length']}"
    return f"{str(error['msg'])[:1].lower()}{str(error['msg'])[1:]}, got {got}"
