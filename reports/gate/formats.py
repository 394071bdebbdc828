"""A verdict as JSON, and as a badge."""

from __future__ import annotations

import json
import math
from dataclasses import asdict
from typing import Any

from reports.gate.verdict import Verdict
from reports.run.provenance import provenance

VERDICT_SCHEMA = 1
COLOURS = {"pass": "brightgreen", "fail": "red", "inconclusive": "yellow"}


def verdict_json(verdict: Verdict, argv: tuple[str, ...] = ()) -> str:
    """Write the verdict with all figures and provenance; an interval's open end is null."""
    record: dict[str, Any] = {
        "kind": "pjpdaf-bench verdict",
        "schema_version": VERDICT_SCHEMA,
        **_plain(asdict(verdict)),
        "provenance": provenance(argv),
    }
    return json.dumps(record, indent=1, ensure_ascii=False, allow_nan=False) + "\n"


def _plain(value: Any) -> Any:
    """Replace infinite numbers, which JSON lacks, by None."""
    if isinstance(value, dict):
        return {key: _plain(part) for key, part in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(part) for part in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def badge_json(verdict: Verdict) -> str:
    """Write the end point format of shields: schemaVersion, label, message, colour."""
    message = "identical" if verdict.identical else verdict.verdict
    badge = {
        "schemaVersion": 1,
        "label": "tracking accuracy",
        "message": message,
        "color": COLOURS[verdict.verdict],
    }
    return json.dumps(badge) + "\n"
