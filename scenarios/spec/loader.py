"""Scenario and suite files: YAML in, records out, every fault one line with its place."""

from __future__ import annotations

from pathlib import Path
from typing import TypeVar

from pydantic import BaseModel, ValidationError

from scenarios.spec.faults import FileFault
from scenarios.spec.scenario import Scenario
from scenarios.spec.suite import Suite
from scenarios.spec.validation import first_fault
from scenarios.spec.value_text import describe_value
from scenarios.spec.yaml_reader import read_yaml
from sim.files import near_paths

MAX_BYTES = 1 << 20
_PACKAGE = Path(__file__).parents[1]
R = TypeVar("R", bound=BaseModel)


def load_scenario_file(path: Path | str) -> Scenario:
    """The scenario of a YAML file. Raises FileFault with the place of the first fault."""
    return parse(read_text(path), str(path), Scenario, Path(path).parent)


def load_suite_file(path: Path | str) -> Suite:
    """The suite of a YAML file. Raises FileFault with the place of the first fault."""
    return parse(read_text(path), str(path), Suite, Path(path).parent)


def load_either_file(path: Path | str) -> Scenario | Suite:
    """The scenario, or the suite (a file with a field `scenarios`), of a YAML file."""
    text = read_text(path)
    data, _ = read_yaml(text, str(path))
    if isinstance(data, dict) and "scenarios" in data:
        return parse(text, str(path), Suite, Path(path).parent)
    return parse(text, str(path), Scenario, Path(path).parent)


def read_text(path: Path | str) -> str:
    """A file's text. Raises FileFault if it is missing, a folder, too large or not UTF-8."""
    file = Path(path)
    try:
        if file.is_dir():
            raise FileFault(str(path), None, "is a folder, not a file")
        with file.open("rb") as stream:
            data = stream.read(MAX_BYTES + 1)
    except FileNotFoundError:
        raise FileFault(str(path), None, f"no such file{near_paths(file)}") from None
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
    """The record of YAML text; `file` names the text in faults.

    folder: where the files lie that the text names. None: the text is shipped, and `file` its name
    below this package. Raises FileFault.
    """
    if folder is None:
        folder = (_PACKAGE / file).parent
    data, positions = read_yaml(text, file)
    if not isinstance(data, dict):
        raise FileFault(file, (1, 1), f"must be a mapping of fields, got {describe_value(data)}")
    try:
        context = {"folder": folder, "file": file, "positions": positions}
        return record.model_validate(data, context=context)
    except ValidationError as error:
        fault = first_fault(error, data, positions, record)
        raise FileFault(file, fault.at, fault.message) from None
