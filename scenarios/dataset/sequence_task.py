"""Makes sequences in worker processes, each whole or not at all."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from pjpdaf.errors import BenchError, InfrastructureError
from pjpdaf.plugins.registry import describe_exception
from reports.run.provenance import PACKAGES, provenance
from scenarios.dataset.folder import locked
from scenarios.dataset.sequence_plan import sequence_entry
from scenarios.play.recipe import FILES, Recipe, stored_name
from sim.contact.contact import Unposable
from sim.dataset.files.checksums import files_below
from sim.dataset.writer import Written, write_sequence
from sim.files import disk_faults
from sim.processes import Answer, Lost, WorkerPool
from sim.sequence import Simulation
from sim.steps import step

TIME_LIMIT_S = 24 * 3600.0  # of one sequence; no code of the user runs in it


@dataclass(frozen=True)
class SequenceTask:
    """A sequence to make. part: the beginning of its temporary folder's name; final: its folder."""

    recipe: Recipe
    part: Path
    final: Path


def library_versions() -> dict[str, str]:
    """Versions of the packages on which the bytes of a data set depend."""
    installed = provenance()["versions"]
    assert isinstance(installed, dict)
    wanted = ("mujoco", "numpy", "opencv-python-headless", "pjpdaf-bench", "scipy", "pyarrow")
    return {name: installed[name] for name in wanted if name in PACKAGES}


def make_sequences(
    pool: WorkerPool, tasks: Mapping[int, SequenceTask], on_done: Callable[[Written], None]
) -> list[Written]:
    """Make the sequences in the pool's workers.

    on_done: called with each that is finished. Raises the BenchError of the first that fails; the
    others are ended then.
    """
    written: list[Written] = []
    for ended in pool.outcomes(_make_sequence, tasks, TIME_LIMIT_S):
        if ended is not None:
            index, outcome = ended
            written.append(_written(tasks[index], outcome))
            on_done(written[-1])
    return written


def _make_sequence(task: SequenceTask) -> Written | BenchError:
    """Make a sequence in a temporary folder, then give it its name. Runs in a worker."""
    if task.final.is_dir():  # a worker was killed between the renaming and its answer
        files = files_below(task.final)
        size = sum(file.stat().st_size for file in files)
        return Written(sequence_entry(0, task.recipe).frames, len(files), size)
    part = task.part.with_name(f"{task.part.name}-{os.getpid()}")
    try:
        with disk_faults(task.final, "the data set"):
            part.mkdir()
            with locked(part):  # no other process removes it while this lives
                written = write_recipe(task.recipe, part)
                part.rename(task.final)
        return written
    except Unposable as fault:  # a BenchError, too
        return BenchError(f"{task.final.name}: cannot be posed: {fault}; leave out this seed")
    except BenchError as fault:
        return fault
    except Exception as fault:
        return InfrastructureError(f"{task.final.name}: {describe_exception(fault)}")
    finally:
        shutil.rmtree(part, ignore_errors=True)


def write_recipe(recipe: Recipe, folder: Path) -> Written:
    """Write a recipe's sequence into an empty folder. Raises BenchError, Unposable, OSError."""
    performance = recipe.performance()
    for file in recipe.files().values():
        (folder / FILES).mkdir(exist_ok=True)
        shutil.copyfile(file.path, folder / FILES / stored_name(file))
    with Simulation(performance) as simulation:
        record = recipe.record(performance.redrawn)
        labels = recipe.settings.labels
        return write_sequence(simulation, folder, labels, record, lambda frame: step())


def _written(task: SequenceTask, outcome: Answer[Written | BenchError] | Lost) -> Written:
    name = task.final.name
    if isinstance(outcome, Lost):
        if outcome.late:
            hours = TIME_LIMIT_S / 3600
            raise InfrastructureError(f"{name}: not finished within {hours:.0f} hours")
        times, code = outcome.attempts, outcome.exit_code
        raise InfrastructureError(f"{name}: its worker died {times} times (exit code {code})")
    if isinstance(outcome.value, BenchError):
        raise outcome.value
    return outcome.value
