"""The verb `dataset verify`: proves a copy of a data set, by its files and by rays."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import typer

from pjpdaf.errors import BenchError
from reports.summary.text import count
from scenarios.console.interrupts import interrupts
from scenarios.console.progress import progress
from scenarios.dataset.check_recipes import recipe_faults
from scenarios.dataset.rays import RayComparison, compare_with_rays
from sim.dataset.raytruth import lines_of
from sim.dataset.reader import open_dataset
from sim.dataset.verify import verify
from sim.processes import WorkerPool


@dataclass(frozen=True)
class VerifyRequest:
    """The options of `dataset verify`.

    sums: read every file to compare its SHA-256 too; rays: frames of the data set, evenly spread,
    that are compared with rays into the rebuilt scenes, 0 for none; jobs: worker processes.
    """

    folder: Path
    sums: bool = True
    rays: int = 4
    jobs: int = 1


def verify_dataset(request: VerifyRequest) -> int:
    """Print every fault, the comparison with rays, and the verdict; returns the exit code 0 or 1.

    Raises BenchError where the folder is not a data set, InfrastructureError where this machine
    cannot rebuild a scene.
    """
    with interrupts() as arrived, arrived.raising():
        return _verify_and_print(request)


def _verify_and_print(request: VerifyRequest) -> int:
    if request.rays < 0 or request.jobs < 1:
        raise BenchError("--rays must be 0 or more, --jobs 1 or more.")
    done: list[str] = []
    with progress() as meter, WorkerPool(request.jobs) as pool:
        frames = _frame_counts(request.folder)
        meter.running = pool.running_steps
        meter.begin("checking", sum(frames.values()) or None)

        def on_sequence(name: str) -> None:
            done.append(name)
            meter.finish(frames.get(name, 0), f"{len(done)}/{count(len(frames), 'sequence')}")

        faults = verify(
            request.folder,
            sums=request.sums,
            on_sequence=on_sequence,
            pool=pool if request.jobs > 1 else None,
        )
        faults = sorted({*faults, *recipe_faults(request.folder, {f.file for f in faults})})
        rays = RayComparison(None)
        if request.rays:
            meter.begin("comparing with rays", request.rays)
            rays = compare_with_rays(request.folder, request.rays, {f.file for f in faults})
    for fault in faults:
        typer.echo(str(fault))
    if request.rays:
        for fault in rays.faults:
            typer.echo(str(fault))
        for reason in rays.refused:
            typer.echo(f"not compared with rays: {reason}")
        for line in lines_of(rays.figures) if rays.figures else []:
            typer.echo(f"rays: {line}")
    number = len(faults) + len(rays.faults)
    verdict = "no fault" if not number else count(number, "fault")
    typer.echo(f"{request.folder}: {count(len(done), 'sequence')}, {verdict}")
    return 1 if number else 0


def _frame_counts(folder: Path) -> dict[str, int]:
    """Frames by sequence, as the manifest says; none where it is damaged, which `verify` says."""
    try:
        sequences = open_dataset(folder).sequences
    except BenchError:
        return {}
    return {s.name: n for s in sequences if isinstance(n := s.entry.get("frames"), int) and n > 0}
