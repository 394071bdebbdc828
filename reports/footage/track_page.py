"""The report page of real footage, which has no truth: status, paths and pictures of the tracks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from pjpdaf.camera import StereoRig
from pjpdaf.interfaces import STATUSES
from reports.footage.plots import paths_chart, time_chart
from reports.footage.track_record import TrackRecord
from reports.page.enlarged_pictures import EnlargedPicture
from reports.page.packing import data_address
from reports.page.templating import rendered, script, shared_scripts, styles
from reports.summary.text import count

FILM_BYTES = 6_000_000  # a longer film is linked, not put inside


@dataclass(frozen=True, eq=False)
class TrackInfo:
    """The set-up of a run over footage.

    complete: the footage was tracked to its end; film: in the page's folder, or None; sources:
    (name, value) of the footage; parameters: all of detector and tracker; changed: those changed
    from the preset; provenance: as `reports.run.provenance`.
    """

    title: str
    complete: bool
    film: Path | None
    rig: StereoRig
    sources: Sequence[tuple[str, str]]
    parameters: Mapping[str, Any]
    changed: Mapping[str, Any]
    provenance: Mapping[str, Any] = field(default_factory=dict)


def track_page(record: TrackRecord, info: TrackInfo) -> str:
    """Build the page of footage: one self-contained HTML text."""
    begun = record.first_frame is not None
    pictures = [
        EnlargedPicture(caption, data_address("image/jpeg", jpeg))
        for caption, jpeg in record.pictures
    ]
    film = info.film
    embedded = film is not None and film.stat().st_size <= FILM_BYTES
    film_type = "video/mp4" if film is not None and film.suffix == ".mp4" else "video/webm"
    return rendered(
        "track.html.j2",
        css=styles("track.css"),
        scripts=[*shared_scripts(), script("lightbox.js")],
        time_chart=time_chart(record.samples, record.missing_frames) if begun else None,
        paths_chart=paths_chart(record.samples) if begun else None,
        record=record,
        info=info,
        summaries=record.summaries(),
        statuses=STATUSES,
        pictures=pictures,
        poster=pictures[len(pictures) // 2].address if pictures else "",
        film=film.name if film is not None else "",
        film_address=data_address(film_type, film.read_bytes()) if film and embedded else "",
        baseline_mm=1000 * float(np.linalg.norm(info.rig.T)),
        more_missing=max(0, record.missing_pictures - len(record.missing_frames)),
        thinned=record.frames > len(record.samples),
        count=count,
    )
