"""Compares frames of a data set with rays into its rebuilt scenes."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from pathlib import Path

from pjpdaf.errors import BenchError, InfrastructureError
from scenarios.play.recipe import performance_from_recipe
from sim.dataset.check.fault import Fault
from sim.dataset.raytruth import RayFigures, lines_of, pooled, ray_check
from sim.dataset.reader import open_dataset
from sim.dataset.stored_sequence import StoredSequence
from sim.sequence import Simulation

NEEDED = {"seg", "depth"}  # labels that rays are compared with


@dataclass(frozen=True, eq=False)
class RayComparison:
    """The result of a comparison.

    figures: over all compared frames, None without any; faults: of sequences that differ from what
    their recipes make; refused: reasons why sequences were not compared.
    """

    figures: RayFigures | None
    faults: tuple[Fault, ...] = ()
    refused: tuple[str, ...] = ()


def compare_with_rays(folder: Path, frames: int, faulty: Collection[str] = ()) -> RayComparison:
    """Compare `frames` frames of a data set, evenly spread, with rays into the rebuilt scenes.

    faulty: files with known faults; the sequences of these are left out. Raises
    InfrastructureError.
    """
    try:
        dataset = open_dataset(folder)
    except BenchError as fault:
        return RayComparison(None, refused=(str(fault),))
    if not set(dataset.labels) >= NEEDED:
        return RayComparison(
            None, refused=(f"{folder}: has no labels {' and '.join(sorted(NEEDED))}",)
        )
    known = {file.partition("/")[0] for file in faulty}
    figures, faults, refused = [], [], []
    for sequence, chosen in _frames_by_sequence(dataset.sequences, frames):
        if sequence.name in known:
            refused.append(f"{sequence.name}: has faults")
            continue
        try:
            with Simulation(
                performance_from_recipe(sequence.recipe, sequence.folder)
            ) as simulation:
                figures_here = ray_check(simulation, sequence, chosen)
        except InfrastructureError:
            raise
        except (BenchError, ValueError) as fault:
            refused.append(f"{sequence.name}: {fault}")
            continue
        figures.append(figures_here)
        if not figures_here.met:
            faults.append(
                Fault(sequence.name, f"is not what its recipe makes: {lines_of(figures_here)[0]}")
            )
    return RayComparison(pooled(figures) if figures else None, tuple(faults), tuple(refused))


def _frames_by_sequence(
    sequences: tuple[StoredSequence, ...], frames: int
) -> Iterator[tuple[StoredSequence, list[int]]]:
    """Yield the sequences that have frames to compare, each with the numbers of these frames."""
    counts = []
    for sequence in sequences:
        try:
            counts.append(sequence.frame_count)
        except BenchError:
            counts.append(0)
    total = sum(counts)
    chosen = sorted({(2 * k + 1) * total // (2 * frames) for k in range(frames)}) if total else []
    start = 0
    for sequence, frame_count in zip(sequences, counts, strict=True):
        mine = [frame - start for frame in chosen if start <= frame < start + frame_count]
        start += frame_count
        if mine:
            yield sequence, mine
