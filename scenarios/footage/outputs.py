"""The page and track.json of tracked footage."""

from __future__ import annotations

import json
import math
from dataclasses import asdict
from pathlib import Path
from typing import Any

from reports.footage.track_page import TrackInfo
from reports.footage.track_record import TrackRecord
from reports.page.templating import write_text
from reports.run.provenance import provenance
from reports.summary.text import count
from scenarios.footage.session import TrackSession


def page_info(session: TrackSession, film: Path | None, complete: bool) -> TrackInfo:
    """The description of a session that its page shows. film: its file, None without one."""
    request = session.request
    background = " and ".join(
        str(path) for path in (request.background_left, request.background_right) if path
    )
    if request.background_first is not None:
        background = f"the first {request.background_first} frames"
    elif request.no_background:
        background = "none: skin alone"
    elif request.background_from_footage:
        background = "median of the footage"
    return TrackInfo(
        title=f"Tracks: {request.out.absolute().name}",
        complete=complete,
        film=film,
        rig=session.rig,
        sources=(
            ("left", str(request.left)),
            ("right", str(request.right) if request.right else f"{request.layout} with left"),
            ("background", background),
            ("calibration", " and ".join(map(str, request.calibration))),
            ("frames a second", f"{session.rate_hz:g}"),
            *_lag_words(session),
        ),
        parameters=session.parameters,
        changed=session.changed,
        provenance=provenance(request.argv),
    )


def _lag_words(session: TrackSession) -> list[tuple[str, str]]:
    """The lag of the estimates, where there is one."""
    lag = session.request.lag
    words = f"{count(lag, 'frame')}, {lag / session.rate_hz:.2f} s later"
    return [("estimates", words)] if lag else []


def write_json(path: Path, session: TrackSession, record: TrackRecord, info: TrackInfo) -> None:
    """Write track.json: sources, parameters, provenance, and frames by status."""
    content = {
        "kind": "pjpdaf-bench track",
        "complete": info.complete,
        "frames": record.frames,
        "rate_hz": session.rate_hz,
        "lag_frames": session.request.lag,
        "missing_pictures": record.missing_pictures,
        "first_tracked_frame": record.first_frame,
        "targets": {summary.target: dict(summary.frames) for summary in record.summaries()},
        "stated": {summary.target: asdict(summary.stated) for summary in record.summaries()},
        "exchange_probability": asdict(record.doubt),
        "sources": dict(info.sources),
        "parameters": dict(session.parameters),
        "changed": sorted(session.changed),
        "provenance": dict(info.provenance),
    }
    content = _without_nan(content)
    write_text(path, json.dumps(content, indent=1, ensure_ascii=False, default=str) + "\n")


def _without_nan(value: Any) -> Any:
    """None in place of NaN, which JSON has not."""
    if isinstance(value, dict):
        return {key: _without_nan(member) for key, member in value.items()}
    return None if isinstance(value, float) and math.isnan(value) else value
