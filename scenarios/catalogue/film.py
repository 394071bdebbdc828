"""The option `--film` of `scenarios show`: a scenario with its truth, as a film or on one sheet."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from rich.console import Console

from pjpdaf.arrays import Image
from pjpdaf.errors import BenchError, InfrastructureError
from reports.pictures.contact_sheet import contact_sheet
from reports.pictures.encode import png_of
from reports.pictures.film import FilmWriter, film_suffix
from reports.pictures.truth_overlay import truth_picture
from scenarios.console.interrupts import unwritten_if_interrupted
from scenarios.console.progress import progress_bar
from scenarios.run.run import read_settings
from scenarios.spec.draw import perform
from scenarios.spec.names import load_scenario
from sim.camera.render import StereoRenderer
from sim.files import disk_faults, written_whole_file
from sim.labels import centres, truth_of, velocities
from sim.scene.world import build
from sim.script import Performance
from sim.sequence import RenderedFrame, Simulation
from sim.truth import Truth

MP4, PNG = ".mp4", ".png"
SHEET_FRAMES, SHEET_COLUMNS, SHEET_WIDTH_PX = 12, 2, 900
TRAIL_S, TRAIL_POINTS = 1.0, 16
HIDDEN_SHARE = 0.3  # less of its skin than this is hardly seen


@dataclass(frozen=True)
class ShowRequest:
    """What the command line asked for; None = not given."""

    name: str
    seed: int
    settings: tuple[str, ...]
    film: Path
    frames: str | None


def show(request: ShowRequest) -> str:
    """Film the scenario, or put it on one sheet; what was written, in words.

    Raises BenchError where something asked for is not possible, InfrastructureError where the
    disk is full or something is not installed, Interrupted after a signal; then nothing is left
    behind.
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
    indices = frame_range(request.frames, performance.frames)
    title = f"{request.name} seed {request.seed}"
    what = "the film" if suffix == MP4 else "the sheet"
    with unwritten_if_interrupted(request.film), written_whole_file(request.film, what) as part:
        if suffix == MP4:
            _film(performance, indices, part, title)
            return f"film: {request.film} ({len(indices)} frames at {performance.fps:g} a second)"
        chosen = _sheet(performance, indices, part, title)
        return f"sheet: {request.film} (frames {', '.join(map(str, chosen))})"


def frame_range(words: str | None, frames: int) -> range:
    """The frames of "A:B", both included, all without. Raises BenchError."""
    if words is None:
        return range(frames)
    first, colon, last = words.partition(":")
    try:
        found = range(int(first or 0), (int(last) if last else frames - 1) + 1)
    except ValueError:
        colon = ""
    if not colon:
        raise BenchError(f"--frames must be FIRST:LAST, such as 10:30, got {words[:60]!r}")
    if not 0 <= found.start < found.stop <= frames:
        raise BenchError(f"--frames {words}: must lie in 0:{frames - 1}, the first before the last")
    return found


def drawn(shot: RenderedFrame, simulation: Simulation, title: str = "") -> Image:
    """A frame with its truth (h, w, 3) BGR."""
    script, skew_s = simulation.performance.script, simulation.performance.scene.sensor.skew_s
    trails = []
    for now_s in (shot.truth.time_s, shot.truth.time_s + skew_s):
        times = np.linspace(max(0.0, now_s - TRAIL_S), now_s, TRAIL_POINTS).tolist()
        trails.append(np.stack([centres(script.pose(t)) for t in times]))
    cameras = simulation.rig.cameras
    return truth_picture(shot.frame, cameras, labels_of(shot), shot.truth, trails, title)


def labels_of(shot: RenderedFrame) -> list[np.ndarray]:
    """The target of each pixel, per view."""
    return [view.targets for view in shot.views if view.targets is not None]


def truths(performance: Performance, indices: Iterable[int]) -> Iterator[Truth]:
    """The truth of some frames without their pictures: a quarter of the time."""
    world, script = build(performance.scene), performance.script
    with StereoRenderer(world) as renderer:
        for index in indices:
            t_s = index / performance.fps
            pose = script.pose(t_s)
            world.place(pose)
            views = renderer.render(colour=False)
            speeds, events = velocities(script, t_s), script.events(t_s)
            yield truth_of(index, pose, speeds, views, world.rig.cameras, events)


def difficulty(truth: Truth) -> int:
    """How many pairs are merged and how many targets hardly seen, over both views."""
    merged = sum(int(view.merged.sum()) // 2 for view in truth.views)
    return merged + sum(int((view.visible_fractions < HIDDEN_SHARE).sum()) for view in truth.views)


def spread(seen: Sequence[Truth], most: int) -> list[int]:
    """Positions of at most `most` frames that tell the story, in order.

    The first, the middle of every stretch in which the same happens (the hard ones first where
    there are too many), then frames in the widest gaps.
    """
    stretches: list[list[int]] = []
    for i, truth in enumerate(seen):
        if i == 0 or _situation(seen[i - 1]) != _situation(truth):
            stretches.append([])
        stretches[-1].append(i)
    told = [s[len(s) // 2] for s in stretches if any(_situation(seen[s[0]]))]
    told.sort(key=lambda i: (-difficulty(seen[i]), i))
    chosen = {0, *told[: most - 1]}
    while len(chosen) < min(most, len(seen)):
        edges = [-1, *sorted(chosen), len(seen)]
        low, high = max(itertools.pairwise(edges), key=lambda gap: gap[1] - gap[0])
        chosen.add((low + high) // 2)
    return sorted(chosen)


def _situation(truth: Truth) -> tuple[object, ...]:
    return truth.script_events, *(
        view.merged.tobytes() for view in truth.views if view.merged.any()
    )


def _performance(request: ShowRequest) -> Performance:
    settings = scenario_settings(request.settings)
    return perform(load_scenario(request.name), request.seed, settings)


def scenario_settings(pairs: Sequence[str]) -> Mapping[str, str]:
    """`--set` words of a scenario alone. Raises BenchError for one of a detector or tracker."""
    settings = read_settings(pairs)
    for part in ("detector", "tracker"):
        for key in getattr(settings, part):
            raise BenchError(f"--set {part}.{key}: a scenario has no {part}")
    return settings.scenario


def _film(performance: Performance, indices: range, part: Path, title: str) -> None:
    console = Console(stderr=True)
    with (
        progress_bar(console) as progress,
        Simulation(performance) as simulation,
        closing(FilmWriter(part.parent, part.stem, performance.fps)) as film,
    ):
        for index in progress.track(indices, description="filming"):
            film.add(drawn(simulation.render(index), simulation, title))


def _sheet(performance: Performance, indices: range, part: Path, title: str) -> list[int]:
    """Write the sheet; the frames on it."""
    console = Console(stderr=True)
    with progress_bar(console) as progress, Simulation(performance) as simulation:
        looked = progress.track(
            truths(performance, indices), total=len(indices), description="looking"
        )
        seen = list(looked)
        chosen = [seen[i].index for i in spread(seen, SHEET_FRAMES)]
        pictures = []
        for index in progress.track(chosen, description="drawing"):
            picture = drawn(simulation.render(index), simulation, title)
            height = round(picture.shape[0] * SHEET_WIDTH_PX / picture.shape[1])
            small = cv2.resize(picture, (SHEET_WIDTH_PX, height), interpolation=cv2.INTER_AREA)
            pictures.append(np.asarray(small, dtype=np.uint8))
    png = png_of(contact_sheet(pictures, SHEET_COLUMNS))
    with disk_faults(part, "the sheet"):
        part.write_bytes(png)
    return chosen
