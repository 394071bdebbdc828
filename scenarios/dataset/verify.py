"""The verb `dataset verify`: proves a copy of a data set, by its files and by rays."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from pathlib import Path

import typer
from rich.console import Console

from pjpdaf.errors import BenchError, InfrastructureError
from reports.summary.text import count
from scenarios.console.interrupts import interrupts
from scenarios.console.progress import progress_bar
from scenarios.play.recipe import performance_of
from sim.dataset.check.fault import Fault
from sim.dataset.raytruth import RayFigures, lines_of, ray_check, together
from sim.dataset.reader import open_dataset
from sim.dataset.stored_sequence import StoredSequence
from sim.dataset.verify import verify
from sim.sequence import Simulation

NEEDED = {"seg", "depth"}  # labels that rays are compared with


@dataclass(frozen=True)
class VerifyRequest:
    """What the command line asked for.

    sums: read every file to compare its SHA-256 too; rays: frames of the data set, evenly spread,
    that are compared with rays into the rebuilt scenes, 0 for none; jobs: worker processes.
    """

    folder: Path
    sums: bool = True
    rays: int = 4
    jobs: int = 1


@dataclass(frozen=True, eq=False)
class Cast:
    """What rays said. figures: of all frames, None where none could be compared; faults: of
    sequences that are not what their recipes make; refused: why a sequence was not compared.
    """

    figures: RayFigures | None
    faults: tuple[Fault, ...] = ()
    refused: tuple[str, ...] = ()


def verify_dataset(request: VerifyRequest) -> int:
    """Print every fault, what rays say, and a last line; 0 where there is no fault, else 1.

    Raises BenchError where the folder is no data set, InfrastructureError where a scene cannot be
    rebuilt on this machine.
    """
    with interrupts() as arrived, arrived.raising():
        return _verify_and_print(request)


def _verify_and_print(request: VerifyRequest) -> int:
    if request.rays < 0 or request.jobs < 1:
        raise BenchError("--rays must be 0 or more, --jobs 1 or more.")
    done: list[str] = []
    with progress_bar(Console(stderr=True)) as progress:
        task = progress.add_task("checking", total=None)

        def on_sequence(name: str) -> None:
            done.append(name)
            progress.update(task, advance=1, description=name)

        faults = verify(
            request.folder, sums=request.sums, on_sequence=on_sequence, jobs=request.jobs
        )
    for fault in faults:
        typer.echo(str(fault))
    cast = Cast(None)
    if request.rays:
        cast = cast_rays(request.folder, request.rays, {fault.file for fault in faults})
        for fault in cast.faults:
            typer.echo(str(fault))
        for why in cast.refused:
            typer.echo(f"not compared with rays: {why}")
        for line in lines_of(cast.figures) if cast.figures else []:
            typer.echo(f"rays: {line}")
    found = len(faults) + len(cast.faults)
    verdict = "no fault" if not found else f"{found} fault{'s' if found > 1 else ''}"
    typer.echo(f"{request.folder}: {count(len(done), 'sequence')}, {verdict}")
    return 1 if found else 0


def cast_rays(folder: Path, frames: int, faulty: Collection[str] = ()) -> Cast:
    """Compare so many frames of a data set, evenly spread, with rays into the rebuilt scenes.

    faulty: files with known faults; the sequences of these are left out. Raises
    InfrastructureError.
    """
    try:
        dataset = open_dataset(folder)
    except BenchError as fault:
        return Cast(None, refused=(str(fault),))
    if not set(dataset.labels) >= NEEDED:
        return Cast(None, refused=(f"{folder}: has no labels {' and '.join(sorted(NEEDED))}",))
    known = {file.partition("/")[0] for file in faulty}
    figures, faults, refused = [], [], []
    for sequence, chosen in _spread(dataset.sequences, frames):
        if sequence.name in known:
            refused.append(f"{sequence.name}: has faults")
            continue
        try:
            with Simulation(performance_of(sequence.recipe, sequence.folder)) as simulation:
                found = ray_check(simulation, sequence, chosen)
        except InfrastructureError:
            raise
        except (BenchError, ValueError) as fault:
            refused.append(f"{sequence.name}: {fault}")
            continue
        figures.append(found)
        if not found.met:
            faults.append(
                Fault(sequence.name, f"is not what its recipe makes: {lines_of(found)[0]}")
            )
    return Cast(together(figures) if figures else None, tuple(faults), tuple(refused))


def _spread(
    sequences: tuple[StoredSequence, ...], frames: int
) -> Iterator[tuple[StoredSequence, list[int]]]:
    """Sequences with the frames of theirs that are looked at."""
    counts = []
    for sequence in sequences:
        try:
            counts.append(sequence.frame_count)
        except BenchError:
            counts.append(0)
    total = sum(counts)
    wanted = sorted({(2 * k + 1) * total // (2 * frames) for k in range(frames)}) if total else []
    start = 0
    for sequence, frame_count in zip(sequences, counts, strict=True):
        mine = [frame - start for frame in wanted if start <= frame < start + frame_count]
        start += frame_count
        if mine:
            yield sequence, mine
