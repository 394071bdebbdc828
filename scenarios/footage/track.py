"""The verb `track`: detector and tracker on real footage, frame by frame."""

from __future__ import annotations

import functools
import itertools
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

from rich.console import Console

from pjpdaf.errors import BenchError
from pjpdaf.follow import follow
from reports.footage.status_table import status_table
from reports.footage.track_page import track_page
from reports.footage.track_record import TrackRecord
from reports.footage.tracks import TrackWriter
from reports.page.templating import write_text
from reports.pictures.film import FilmWriter
from reports.pictures.overlay import encode_jpeg, overlay_picture
from reports.summary.text import count
from scenarios.console.folder import written_whole
from scenarios.console.interrupts import Interrupted, Interrupts, interrupts
from scenarios.console.lines import print_line
from scenarios.console.progress import progress
from scenarios.console.tables import print_table
from scenarios.footage.learning import learn_scene
from scenarios.footage.outputs import page_info, write_json
from scenarios.footage.session import TrackRequest, TrackSession, prepare_session


def track(request: TrackRequest) -> None:
    """Track, save, print.

    Raises BenchError; Interrupted after a signal; KeyboardInterrupt after a second signal while
    frames are still tracked, and then nothing is saved. After a signal, or a fault in mid-footage,
    the frames before it are saved.
    """
    console = Console(stderr=True)

    def warn(message: str) -> None:
        print_line(message, console)

    with written_whole(request.out) as part:
        session = prepare_session(request, warn)
        with interrupts() as arrived:
            with arrived.raising(at=2):
                with console.status("learning the background"):
                    session = learn_scene(session, warn)
                record, film, fault = _follow(session, part, console, warn, arrived)
            info = page_info(session, film, complete=not arrived.arrived and fault is None)
            write_text(part / "report.html", track_page(record, info))
            write_json(part / "track.json", session, record, info)
    out = Console()
    print_table(status_table(record), out)
    for line in (
        f"{count(record.frames, 'stereo frame')}, {record.seconds:.1f} s, "
        f"{count(record.missing_pictures, 'picture')} missing",
        record.verdict(),
        f"tracks: {request.out / 'tracks.csv'}",
        f"film:   {request.out / film.name}" if film else "film:   none",
        f"report: {request.out / 'report.html'}",
    ):
        print_line(line, out)
    kept = f"the first {count(record.frames, 'frame')} are saved in {request.out}"
    if fault is not None:
        raise fault.reworded(f"{str(fault).rstrip('.')}; {kept}")
    if arrived.arrived:
        raise Interrupted(f"interrupted: {kept}")


def _follow(
    session: TrackSession,
    part: Path,
    console: Console,
    warn: Callable[[str], None],
    arrived: Interrupts,
) -> tuple[TrackRecord, Path | None, BenchError | None]:
    """Detect and track all frames.

    Returns the record, the film, and the fault of the input that ended the footage early, if any.
    """
    ended_by: BenchError | None = None
    cameras = session.rig.cameras
    record = TrackRecord(1 / session.rate_hz)
    with progress(console) as meter:
        meter.begin("tracking", session.total)
        frames = itertools.takewhile(lambda _: not arrived.arrived, session.frames(warn))
        with (
            closing(TrackWriter(part, cameras)) as tracks,
            closing(FilmWriter(part, "overlay", session.rate_hz)) as film,
        ):
            try:
                for step in follow(frames, session.detector, session.tracker, session.request.lag):
                    frame, detections, estimates = step.frame, step.detections, step.estimates
                    sheet = overlay_picture(frame, cameras, detections, estimates)
                    tracks.add(frame.index, frame.time_s, estimates)
                    film.add(sheet)
                    record.add(frame, detections, estimates, functools.partial(encode_jpeg, sheet))
                    meter.step()
            except BenchError as fault:
                if record.frames == 0:
                    raise
                ended_by = fault  # the frames tracked before it are kept
    if record.frames == 0:
        raise Interrupted("interrupted before any frame was tracked; nothing saved")
    return record, film.path, ended_by
