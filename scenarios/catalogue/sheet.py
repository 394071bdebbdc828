"""The verb `scenarios sheet`: a picture of each of the first episodes of a scenario or suite."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

from pjpdaf.arrays import Image
from pjpdaf.errors import BenchError
from reports.pictures.contact_sheet import contact_sheet
from reports.pictures.encode import jpeg_of, png_of, webp_of
from reports.pictures.resize import resized
from reports.summary.text import count
from scenarios.console.interrupts import unwritten_if_interrupted
from scenarios.console.progress import progress
from scenarios.play.job import Job
from scenarios.play.plan import PlanRequest, plan
from scenarios.spec.draw import perform
from sim.contact.contact import Unposable
from sim.files import disk_faults, written_whole_file
from sim.sequence import Simulation
from sim.steps import counted

COLUMNS, WIDTH_PX = 6, 256  # pictures a row, and the breadth of each
_ENCODERS: Mapping[str, Callable[[Image], bytes]] = {
    ".webp": lambda picture: webp_of(picture, 80),
    ".jpg": lambda picture: jpeg_of(picture, 85, optimised=True),
    ".png": png_of,
}


@dataclass(frozen=True)
class SheetRequest:
    """The options of `scenarios sheet`: scenarios or suites, how many pictures, seeds, file."""

    targets: tuple[str, ...]
    pictures: int
    seeds: int | None
    first_seed: int
    settings: tuple[str, ...]
    out: Path


def write_sheet(request: SheetRequest) -> str:
    """Write the left view of the middle frame of the first episodes; returns the message.

    Every scenario's first seed comes before any second. An episode that cannot be posed is left
    out. Raises BenchError, InfrastructureError, Interrupted; then no file is left behind.
    """
    suffix = request.out.suffix.lower()
    if suffix not in _ENCODERS:
        raise BenchError(f"--out {request.out}: must end in {', '.join(_ENCODERS)}")
    if not 1 <= request.pictures <= 400:
        raise BenchError(f"--pictures must be between 1 and 400, got {request.pictures}")
    jobs = plan(
        PlanRequest(request.targets, request.seeds, request.first_seed, settings=request.settings)
    )
    order = sorted(range(len(jobs)), key=lambda i: (jobs[i].seed, i))
    chosen = list(islice(order, request.pictures))
    with (
        unwritten_if_interrupted(request.out),
        written_whole_file(request.out, "the sheet") as part,  # a file that is there is left alone
        progress() as meter,
    ):
        meter.begin("drawing", len(chosen))
        every = (middle_picture(jobs[i]) for i in counted(chosen))
        drawn = [picture for picture in every if picture is not None]
        if not drawn:
            raise BenchError("none of these episodes can be posed: use other seeds")
        with disk_faults(part, "the sheet"):
            part.write_bytes(_ENCODERS[suffix](contact_sheet(drawn, COLUMNS)))
    return f"sheet: {request.out} ({count(len(drawn), 'episode')})"


def middle_picture(job: Job) -> Image | None:
    """The left view (h, WIDTH_PX, 3) BGR of an episode's middle frame; None if it has no pose."""
    try:
        performance = perform(job.scenario, job.seed, job.overrides)
    except Unposable:
        return None
    with Simulation(performance) as simulation:
        light = simulation.render(performance.frames // 2).light[0]
    return resized(light, WIDTH_PX)
