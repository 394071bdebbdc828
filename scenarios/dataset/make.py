"""The verb `dataset make`: makes a data set, or goes on with an unfinished one."""

from __future__ import annotations

import time
from collections.abc import Collection, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path

from rich.filesize import decimal

from pjpdaf.errors import BenchError
from reports.summary.text import count, duration
from scenarios.console.interrupts import Interrupted, interrupts
from scenarios.console.progress import Meter, progress
from scenarios.dataset.finish import check_libraries, finish_dataset
from scenarios.dataset.folder import (
    check_same_dataset,
    check_same_versions,
    only_process,
    remove_leftovers,
)
from scenarios.dataset.forecast import forecast, refuse_without_room, try_sequences
from scenarios.dataset.sequence_plan import (
    MakeRequest,
    plan_recipes,
    repeat_command,
    sequence_entry,
)
from scenarios.dataset.sequence_task import SequenceTask, library_versions, make_sequences
from scenarios.execute.executor import ClusterFault, Executor
from scenarios.execute.local import worker_count
from scenarios.execute.place import Place, executor_at, place_of
from scenarios.execute.software import PlugIns
from scenarios.play.footage import plugged_motions
from scenarios.play.recipe import Recipe
from sim.dataset.files.layout import (
    MANIFEST,
    PART,
)
from sim.dataset.files.manifest import SequenceEntry, manifest_record, write_manifest
from sim.dataset.writer import Written
from sim.files import disk_faults

# A worker is replaced after this many sequences: whatever a driver leaks goes with it.
SEQUENCES_A_WORKER = 64


def make_dataset(request: MakeRequest, workers: Executor | None = None) -> None:
    """Make a data set, or go on with an unfinished one, and print its size.

    workers: an executor of the caller's, which stays open; without it `request.jobs` are started.
    Raises BenchError; Interrupted after a signal.
    """
    place = place_of(request.jobs, request.cluster)
    check_libraries(request.exports)
    recipes = plan_recipes(request)
    out = request.out.absolute()
    settings = {**request.labels.record(), "ladder": request.ladder}
    entries = [sequence_entry(index, recipe) for index, recipe in enumerate(recipes)]
    command = repeat_command(request)
    with disk_faults(out, "the data set"):
        out.mkdir(parents=True, exist_ok=True)
    with only_process(out), interrupts() as arrived, arrived.raising():
        check_same_dataset(out, settings, entries)
        try:
            motions = plugged_motions(recipe.job for recipe in recipes)
            plug_ins = PlugIns().with_motions(motions)
            own = executor_at(place, plug_ins, tasks_per_worker=SEQUENCES_A_WORKER)
            with own if workers is None else nullcontext(workers) as executor:
                made_with = {
                    "renderer": _only(executor.renderers()),
                    "versions": library_versions(),
                }
                check_same_versions(out, made_with)
                remove_leftovers(out)
                if not (out / MANIFEST).exists():
                    record = manifest_record(entries, settings, made_with, False, command)
                    write_manifest(out, record)
                tasks = {
                    index: SequenceTask(
                        replace(recipes[index], made_with=made_with),
                        out / f"{PART}{entry.folder}",
                        out / entry.folder,
                    )
                    for index, entry in enumerate(entries)
                    if not (out / entry.folder).is_dir()
                }
                frames = sum(entries[index].frames for index in tasks)
                _state_expected(executor, out, recipes, tasks, request.exports, place)
                started = time.perf_counter()
                with progress(running=executor.running_steps) as meter:
                    written = _make_all(executor, tasks, meter, apart=bool(place.scheduler))
            remove_leftovers(out)  # of workers that were killed
            wall_s = time.perf_counter() - started
            with progress() as meter:
                jobs = place.workers or worker_count(None)  # exports are written here
                finish_dataset(
                    out, entries, settings, made_with, request.exports, command, jobs, meter
                )
        except KeyboardInterrupt:
            remove_leftovers(out)
            raise Interrupted(f"interrupted: {_finished(out, entries)}") from None
        except ClusterFault as fault:
            raise fault.reworded(f"{fault}; {_finished(out, entries)}") from fault
        except BaseException:
            remove_leftovers(out)
            raise
    size = sum(sequence.bytes for sequence in written)
    summary = f"{count(len(tasks), 'sequence')}, {count(frames, 'stereo frame')}"
    if tasks:
        summary += f", {decimal(size)} in {wall_s:.0f} s ({frames / wall_s:.1f} frames/s)"
    kept = len(entries) - len(tasks)
    print(f"{summary}, {place}" + (f"; {kept} were there" if kept else ""))
    print(f"data set: {request.out}")


def _state_expected(
    executor: Executor,
    out: Path,
    recipes: Sequence[Recipe],
    tasks: Mapping[int, SequenceTask],
    exports: Sequence[str],
    place: Place,
) -> None:
    """Print the expected size and time of what is to be made, unless that is little.

    Raises InfrastructureError where the disk has not enough room.
    """
    missing = {index: recipes[index] for index in tasks}
    with progress() as meter:
        meter.begin("making a few frames, to tell size and time", None)
        expected = forecast(
            try_sequences(executor, missing), missing, recipes, exports, place.workers or 1
        )
    if expected is None:
        return
    free = refuse_without_room(expected, out)
    exported = f" ({decimal(expected.exports)} of it exports)" if expected.exports else ""
    print(
        f"expected: about {decimal(expected.size)}{exported} in {duration(expected.seconds)}"
        f"{'' if place.workers else ' of one worker'}; the disk has {decimal(free)} left\n"
        f"a stereo frame: about {decimal(round(expected.pictures))} of pictures, "
        f"{decimal(round(expected.labels))} of labels, {expected.cpu_s:.2f} s of a core",
        flush=True,
    )


def _make_all(
    executor: Executor, tasks: Mapping[int, SequenceTask], meter: Meter, apart: bool
) -> list[Written]:
    done: list[Written] = []

    def doing() -> str:
        size = f", {decimal(sum(sequence.bytes for sequence in done))}" if done else ""
        return f"{len(done)}/{count(len(tasks), 'sequence')}{size}"

    def on_done(written: Written) -> None:
        done.append(written)
        meter.finish(written.frames, doing())

    meter.begin(doing(), sum(task.recipe.job.frames for task in tasks.values()))
    return make_sequences(executor, tasks, on_done, apart=apart)


def _only(renderers: Collection[str]) -> str:
    """The renderer of all workers. Raises BenchError where they differ."""
    if len(renderers) > 1:
        raise BenchError(
            f"the workers draw with different renderers ({'; '.join(sorted(renderers))}): the "
            "pictures of a data set must be of one; use workers of one kind"
        )
    return next(iter(renderers))


def _finished(out: Path, entries: Sequence[SequenceEntry]) -> str:
    done = sum((out / entry.folder).is_dir() for entry in entries)
    return f"{done} of {count(len(entries), 'sequence')} are in {out}; the same command goes on"
