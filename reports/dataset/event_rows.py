"""Events of a sequence as rows of intervals beside the slider."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from reports.words import label_text, pair_text, readable_name

MOST_ROWS, MOST_SPANS = 40, 400


def event_rows(events: Mapping[str, Any], frames: int) -> list[dict[str, Any]]:
    """A row per event: its kind, its text, its intervals of frames (first, last).

    Entries in another form than `events_of` writes are left out: the file may be a stranger's.
    """
    rows: dict[tuple[str, str], list[list[int]]] = {}
    for kind in ("merges", "ambiguous", "occlusions", "script"):
        listed = events.get(kind)
        for event in listed if isinstance(listed, list) else ():
            span = _span(event, frames)
            if span is not None:
                rows.setdefault((kind, _event_text(kind, event)), []).append(span)
    return [
        {"kind": kind, "text": text, "spans": spans[:MOST_SPANS]}
        for (kind, text), spans in list(rows.items())[:MOST_ROWS]
    ]


def _span(event: Any, frames: int) -> list[int] | None:
    if not isinstance(event, Mapping):
        return None
    first, last = event.get("first_frame"), event.get("last_frame")
    if not (isinstance(first, int) and isinstance(last, int) and 0 <= first <= last):
        return None
    return [first, min(last, frames - 1)] if first < frames else None


def _event_text(kind: str, event: Mapping[str, Any]) -> str:
    def value(key: str) -> str:
        return readable_name(str(event.get(key, "?"))[:60])

    if kind == "merges":
        targets = event.get("targets")
        pair = [str(t)[:40] for t in targets[:2]] if isinstance(targets, list) else []
        return f"{pair_text(pair)} merged, {value('view')} view"
    if kind == "ambiguous":
        return "both hands one blob in both views"
    if kind == "occlusions":
        return f"{value('target')} hidden by {value('by')}, {value('view')} view"
    return label_text(str(event.get("event", "?"))[:60])
