"""The option `--film` of `scenarios show`: a scenario with its truth, as a film or on one sheet."""

from __future__ import annotations

from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pjpdaf.arrays import Image
from pjpdaf.errors import BenchError, InfrastructureError
from reports.pictures.contact_sheet import contact_sheet
from reports.pictures.encode import png_of
from reports.pictures.film import FilmWriter, film_suffix
from reports.pictures.resize import resized
from reports.pictures.truth_overlay import truth_picture
from reports.summary.text import count
from scenarios.catalogue.frame_choice import representative_frames, truths_without_pictures
from scenarios.console.interrupts import unwritten_if_interrupted
from scenarios.console.progress import progress
from scenarios.play.settings import read_scenario_settings
from scenarios.spec.draw import perform
from scenarios.spec.motion.plugged import trust
from scenarios.spec.names import load_scenario
from sim.files import disk_faults, written_whole_file
from sim.labels import centres
from sim.script import Performance
from sim.sequence import RenderedFrame, Simulation
from sim.steps import counted

MP4, PNG = ".mp4", ".png"
SHEET_FRAMES, SHEET_COLUMNS, SHEET_WIDTH_PX = 12, 2, 900
TRAIL_S, TRAIL_POINTS = 1.0, 16


@dataclass(frozen=True)
class FilmRequest:
    """The options of `scenarios show --film`; None = not given."""

    name: str
    seed: int
    settings: tuple[str, ...]
    film: Path
    frames: str | None


def film_scenario(request: FilmRequest) -> str:
    """Film the scenario, or put twelve frames on one sheet; returns the message to print.

    Raises BenchError for options that cannot be met, InfrastructureError where the disk is full or
    PyAV is not installed, Interrupted after a signal; then no file is left behind.
    """
    suffix = request.film.suffix.lower()
    if suffix not in (MP4, PNG):
        raise BenchError(f"--film {request.film}: must end in {MP4} (film) or {PNG} (one sheet).")
    if suffix == MP4 and film_suffix() != MP4:
        raise InfrastructureError(
            f"--film {request.film}: films need the extra: pip install 'pjpdaf-bench[video]'; "
            f"a {PNG} needs nothing."
        )
    performance = _performance(request)
    indices = parse_frame_range(request.frames, performance.frames)
    title = f"{request.name} seed {request.seed}"
    kind = "the film" if suffix == MP4 else "the sheet"
    with unwritten_if_interrupted(request.film), written_whole_file(request.film, kind) as part:
        if suffix == MP4:
            _film(performance, indices, part, title)
            frames = count(len(indices), "frame")
            return f"film: {request.film} ({frames} at {performance.fps:g} a second)"
        chosen = _sheet(performance, indices, part, title)
        return f"sheet: {request.film} (frames {', '.join(map(str, chosen))})"


def parse_frame_range(text: str | None, frames: int) -> range:
    """Read "A:B", both included; None: all `frames` frames. Raises BenchError."""
    if text is None:
        return range(frames)
    first, colon, last = text.partition(":")
    try:
        chosen = range(int(first or 0), (int(last) if last else frames - 1) + 1)
    except ValueError:
        colon = ""
    if not colon:
        raise BenchError(f"--frames must be FIRST:LAST, such as 10:30, got {text[:60]!r}")
    if not 0 <= chosen.start < chosen.stop <= frames:
        raise BenchError(f"--frames {text}: must lie in 0:{frames - 1}, the first before the last")
    return chosen


def draw_truth(shot: RenderedFrame, simulation: Simulation, title: str = "") -> Image:
    """Draw the truth into both views of a frame: (h, w, 3) BGR."""
    script, skew_s = simulation.performance.script, simulation.performance.scene.sensor.skew_s
    trails = []
    for now_s in (shot.truth.time_s, shot.truth.time_s + skew_s):
        times = np.linspace(max(0.0, now_s - TRAIL_S), now_s, TRAIL_POINTS).tolist()
        trails.append(np.stack([centres(script.pose(t)) for t in times]))
    cameras = simulation.rig.cameras
    return truth_picture(shot.frame, cameras, target_labels(shot), shot.truth, trails, title)


def target_labels(shot: RenderedFrame) -> list[np.ndarray]:
    """The picture of target numbers of each view."""
    return [view.targets for view in shot.views if view.targets is not None]


def _performance(request: FilmRequest) -> Performance:
    settings = read_scenario_settings(request.settings)
    trust(request.name)
    return perform(load_scenario(request.name), request.seed, settings)


def _film(performance: Performance, indices: range, part: Path, title: str) -> None:
    with (
        progress() as meter,
        Simulation(performance) as simulation,
        closing(FilmWriter(part.parent, part.stem, performance.fps)) as film,
    ):
        meter.begin("filming", len(indices))
        for index in counted(indices):
            film.add(draw_truth(simulation.render(index), simulation, title))


def _sheet(performance: Performance, indices: range, part: Path, title: str) -> list[int]:
    """Write the sheet; returns the numbers of the frames on it."""
    with progress() as meter, Simulation(performance) as simulation:
        meter.begin("looking", len(indices))
        truths = list(counted(truths_without_pictures(performance, indices)))
        chosen = [truths[i].index for i in representative_frames(truths, SHEET_FRAMES)]
        pictures = []
        meter.begin("drawing", len(chosen))
        for index in counted(chosen):
            picture = draw_truth(simulation.render(index), simulation, title)
            pictures.append(resized(picture, SHEET_WIDTH_PX))
    with disk_faults(part, "the sheet"):
        part.write_bytes(png_of(contact_sheet(pictures, SHEET_COLUMNS)))
    return chosen
