"""Makes sequences in worker processes, each whole or not at all."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, TypeVar

from pjpdaf.errors import BenchError, InfrastructureError
from pjpdaf.plugins.loading import describe_exception
from reports.run.provenance import PACKAGES, versions
from scenarios.dataset.folder import locked
from scenarios.dataset.sequence_plan import sequence_entry
from scenarios.execute.executor import Executor
from scenarios.play.recipe import FILES, Recipe, stored_name
from sim import gl
from sim.contact.contact import Unposable
from sim.dataset.files.checksums import files_below
from sim.dataset.writer import Written, write_sequence
from sim.files import disk_faults
from sim.processes import Answer, Lost
from sim.sequence import Simulation
from sim.steps import step

R = TypeVar("R")
TIME_LIMIT_S = 24 * 3600.0  # of one sequence; no code of the user runs in it


@dataclass(frozen=True)
class SequenceTask:
    """A sequence to make. part: the beginning of its temporary folder's name; final: its folder."""

    recipe: Recipe
    part: Path
    final: Path


@dataclass(frozen=True)
class SentSequence:
    """A sequence on its way from another machine. files: content by path below its folder."""

    written: Written
    files: Mapping[str, bytes]


def library_versions() -> dict[str, str]:
    """Versions of the packages on which the bytes of a data set depend."""
    installed = versions()
    wanted = ("mujoco", "numpy", "opencv-python-headless", "pjpdaf-bench", "scipy", "pyarrow")
    return {name: installed[name] for name in wanted if name in PACKAGES}


def make_sequences(
    executor: Executor,
    tasks: Mapping[int, SequenceTask],
    on_done: Callable[[Written], None],
    *,
    apart: bool = False,
) -> list[Written]:
    """Make the sequences on an executor.

    on_done: called with each that is finished. apart: its processes may have other disks; then they
    send the files, which are written here. Raises the BenchError of the first that fails; the
    others are ended then.
    """
    written: list[Written] = []
    make: Callable[[SequenceTask], Any] = _make_and_send if apart else _make_sequence
    for ended in executor.outcomes(make, tasks, TIME_LIMIT_S):
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

    def make() -> Written:
        with _new_folder(task) as part:
            return write_recipe(task.recipe, part)

    return _value_or_fault(task, make)


def _make_and_send(task: SequenceTask) -> SentSequence | BenchError:
    """Make a sequence on a disk of the worker's own. Runs in a worker."""

    def make() -> SentSequence:
        with TemporaryDirectory(prefix="pjpdaf-bench-") as name, disk_faults(Path(name), "files"):
            folder = Path(name)
            written = write_recipe(task.recipe, folder)
            _check_renderer(task.recipe)
            files = {p.relative_to(folder).as_posix(): p.read_bytes() for p in files_below(folder)}
            return SentSequence(written, files)

    return _value_or_fault(task, make)


def _store(task: SequenceTask, sent: SentSequence) -> Written:
    """Write a sequence that was sent. Raises BenchError of the disk."""
    with _new_folder(task) as part:
        for name, content in sent.files.items():
            (part / name).parent.mkdir(parents=True, exist_ok=True)
            (part / name).write_bytes(content)
    return sent.written


@contextmanager
def _new_folder(task: SequenceTask) -> Iterator[Path]:
    """A temporary folder, which becomes the task's at the end. Raises BenchError of the disk."""
    part = task.part.with_name(f"{task.part.name}-{os.getpid()}")
    with disk_faults(task.final, "the data set"):
        try:
            part.mkdir()
            with locked(part):  # no other process removes it while this lives
                yield part
                part.rename(task.final)
        finally:
            shutil.rmtree(part, ignore_errors=True)


def _value_or_fault(task: SequenceTask, make: Callable[[], R]) -> R | BenchError:
    try:
        return make()
    except Unposable as fault:  # a BenchError, too
        return BenchError(f"{task.final.name}: cannot be posed: {fault}; leave out this seed")
    except BenchError as fault:
        return fault
    except Exception as fault:
        return InfrastructureError(f"{task.final.name}: {describe_exception(fault)}")


def _check_renderer(recipe: Recipe) -> None:
    """Raise InfrastructureError where another renderer draws here than in the other sequences."""
    here, wanted = gl.describe(), (recipe.made_with or {}).get("renderer")
    if here != wanted:
        raise InfrastructureError(
            f"a worker draws with {here}, the other sequences were drawn with {wanted}: use "
            "workers of one kind"
        )


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


def _written(task: SequenceTask, outcome: Answer[Any] | Lost) -> Written:
    name = task.final.name
    if isinstance(outcome, Lost):
        if outcome.late:
            hours = TIME_LIMIT_S / 3600
            raise InfrastructureError(f"{name}: not finished within {hours:.0f} hours")
        raise InfrastructureError(f"{name}: {outcome.death}")
    if isinstance(outcome.value, BenchError):
        raise outcome.value
    if isinstance(outcome.value, SentSequence):
        return _store(task, outcome.value)
    written: Written = outcome.value
    return written
