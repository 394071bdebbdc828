"""The JSON schema of scenario files, and the field names that it knows."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pydantic import BaseModel

from scenarios.spec.faults import FieldPath
from scenarios.spec.motion.kinds import SCRIPT
from scenarios.spec.motion.steps import RECORDS
from scenarios.spec.scenario import Scenario

DISTRIBUTIONS = ("Uniform", "LogUniform", "Normal", "Fixed")
# The field that tells a file or a choice from a number, and its definition in the schema.
_PARAMETERS = {"file": "File", "choices": "Choice"}


def json_schema() -> dict[str, Any]:
    """The JSON schema of a scenario file, for editors."""
    schema = Scenario.model_json_schema()
    schema["$schema"] = "https://json-schema.org/draft/2020-12/schema"
    # Numbers may also be text with a unit; editors should not mark that.
    quantity = {"anyOf": [{"type": "number"}, {"type": "string"}]}
    definitions = schema.get("$defs", {})
    for name in DISTRIBUTIONS:
        for key, field in definitions[name]["properties"].items():
            if key != "kind":
                definitions[name]["properties"][key] = quantity | {"title": field.get("title", key)}
    definitions["Numeric"]["properties"]["range"]["prefixItems"] = [quantity, quantity]
    return schema


def fields_beside(path: FieldPath, data: Any, record: type[BaseModel]) -> list[str]:
    """Names of the fields that may stand where the last name of a path stands.

    data: the whole file's values; record: the type of the file's record.
    """
    above = [str(name) for name in path[:-1]]
    schema: Mapping[str, Any] = record.model_json_schema()
    definitions = schema.get("$defs", {})
    if not above:
        return list(schema["properties"])
    if above[0] == "parameters" and record is Scenario:
        if len(above) == 2:
            siblings = data["parameters"][above[1]]
            name = next((d for field, d in _PARAMETERS.items() if field in siblings), "Numeric")
            return list(definitions[name]["properties"])
        if len(above) == 3:
            kind = data["parameters"][above[1]]["nominal"].get("kind")
            for name in DISTRIBUTIONS:
                properties = definitions[name]["properties"]
                if properties["kind"]["const"] == kind:
                    return list(properties)
    if above[0] == "motion":
        return _fields_of_motion(above, data["motion"], definitions)
    if above[0] == "scenarios":
        return list(definitions["SuiteEntry"]["properties"])
    return []


def _fields_of_motion(
    above: list[str], motion: Mapping[str, Any], definitions: Mapping[str, Any]
) -> list[str]:
    """Names of the fields of a motion, of an object or step of a script, or of a step's target."""
    if motion.get("kind") != SCRIPT:
        return list(definitions["Motion"]["properties"])
    if len(above) == 1:
        return list(definitions["ScriptMotion"]["properties"])
    if above[1] == "objects":
        return list(definitions["ObjectFields"]["properties"])
    if len(above) > 3:
        return list(definitions["TargetFields"]["properties"])
    step = RECORDS[motion["steps"][int(above[2])]["do"]]
    return [field.alias or name for name, field in step.model_fields.items()]
