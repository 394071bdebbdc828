"""Events in words, from rows of the table of events."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from reports.summary.text import LABELS


def event_text(event: Mapping[Any, Any]) -> str:
    """An event in words, such as "right hand captured by head"."""
    target = LABELS[event["target"]]
    return {
        "swap": "hands swapped",
        "capture": f"{target} captured by {LABELS.get(event['other'], '?')}",
        "lost": f"{target} lost",
        "recovered": f"{target} recovered",
    }[event["kind"]]
