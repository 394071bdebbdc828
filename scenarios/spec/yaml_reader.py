"""YAML text to plain values, with the line and column of every field."""

from __future__ import annotations

from copy import deepcopy
from functools import lru_cache
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.error import MarkedYAMLError, YAMLError
from ruamel.yaml.events import AliasEvent, CollectionEndEvent, CollectionStartEvent, NodeEvent
from ruamel.yaml.nodes import MappingNode, Node, ScalarNode, SequenceNode
from ruamel.yaml.reader import ReaderError

from scenarios.spec.faults import FieldPath, FileFault, Positions, dotted

MAX_DEPTH = 30
_TAG = "tag:yaml.org,2002:"


def read_yaml(text: str, file: str) -> tuple[Any, Positions]:
    """The values of YAML text, and where each field stands; `file` names the text in faults.

    No anchors, no tags, no key twice. Raises FileFault.
    """
    return deepcopy(_read(text, file))  # the caller's own: validators may change them


# Stress asks for a scenario file with each trial, and YAML takes half as long as one.
@lru_cache(maxsize=16)
def _read(text: str, file: str) -> tuple[Any, Positions]:
    yaml = YAML(typ="safe", pure=True)
    try:
        depth = 0
        for event in yaml.parse(text):
            at = _position(event)
            if isinstance(event, AliasEvent) or (isinstance(event, NodeEvent) and event.anchor):
                raise FileFault(file, at, "anchors and aliases (& and *) are not allowed")
            depth += isinstance(event, CollectionStartEvent)
            depth -= isinstance(event, CollectionEndEvent)
            if depth > MAX_DEPTH:
                raise FileFault(file, at, f"is nested deeper than {MAX_DEPTH} levels")
        node = YAML(typ="safe", pure=True).compose(text)
    except MarkedYAMLError as fault:
        mark = fault.problem_mark or fault.context_mark
        marked_at = None if mark is None else (mark.line + 1, mark.column + 1)
        problem = (fault.problem or "cannot be read").splitlines()[0]
        raise FileFault(file, marked_at, f"is not YAML: {problem}") from None
    except ReaderError as fault:
        lines = text[: fault.position].split("\n")
        at = len(lines), len(lines[-1]) + 1
        raise FileFault(file, at, f"is not YAML: {fault.reason}") from None
    except (YAMLError, RecursionError) as fault:
        problem = (str(fault) or "nested too deeply").splitlines()[0]
        raise FileFault(file, None, f"is not YAML: {problem}") from None
    positions: Positions = {}
    if node is None:
        return None, positions
    positions[()] = _position(node)
    return _value(node, (), positions, file), positions


def _position(marked: Any) -> tuple[int, int]:
    """Line and column, from 1, at which a node or an event starts."""
    return marked.start_mark.line + 1, marked.start_mark.column + 1


def _value(node: Node, path: FieldPath, positions: Positions, file: str) -> Any:
    at = _position(node)
    if isinstance(node, MappingNode):
        _expect_tag(node, "map", at, path, file)
        mapping: dict[str, Any] = {}
        for key_node, value_node in node.value:
            key_at = _position(key_node)
            if not isinstance(key_node, ScalarNode):
                raise FileFault(file, key_at, f"{dotted(path)}a field's name must be a word")
            key = key_node.value
            if key in mapping:
                raise FileFault(file, key_at, f"{dotted((*path, key))}is given twice")
            positions[(*path, key)] = key_at
            mapping[key] = _value(value_node, (*path, key), positions, file)
        return mapping
    if isinstance(node, SequenceNode):
        _expect_tag(node, "seq", at, path, file)
        items = []
        for index, item in enumerate(node.value):
            positions[(*path, index)] = _position(item)
            items.append(_value(item, (*path, index), positions, file))
        return items
    return _scalar(node, path, at, file)


def _expect_tag(node: Node, kind: str, at: tuple[int, int], path: FieldPath, file: str) -> None:
    if str(node.tag) != _TAG + kind:
        raise FileFault(file, at, f"{dotted(path)}tags are not allowed, got {str(node.tag)[:60]}")


def _scalar(node: ScalarNode, path: FieldPath, at: tuple[int, int], file: str) -> Any:
    tag, text = str(node.tag), str(node.value)
    if not tag.startswith(_TAG):
        raise FileFault(file, at, f"{dotted(path)}tags are not allowed, got {tag[:60]}")
    kind = tag[len(_TAG) :]
    try:
        if kind == "int":
            plain = text.replace("_", "")
            return int(plain, 0) if plain.lstrip("+-").lower()[:2] in ("0x", "0o") else int(plain)
        if kind == "float":
            plain = text.replace("_", "").lower()
            return float(plain.replace(".inf", "inf").replace(".nan", "nan"))
    except (ValueError, OverflowError):
        raise FileFault(file, at, f"{dotted(path)}cannot be read as a number") from None
    if kind == "bool":
        return text.lower() == "true"
    if kind == "null":
        return None
    if kind in ("str", "timestamp"):
        return text
    raise FileFault(file, at, f"{dotted(path)}tags are not allowed, got !!{kind[:60]}")
