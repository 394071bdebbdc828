"""The verb `dataset make`: makes a data set, or goes on with an unfinished one."""

from __future__ import annotations

import time
from contextlib import nullcontext
from dataclasses import replace

from rich.console import Console
from rich.filesize import decimal

from reports.summary.text import count
from scenarios.console.interrupts import Interrupted, interrupts
from scenarios.dataset.finish import finish_dataset
from scenarios.dataset.folder import (
    check_same_dataset,
    check_same_versions,
    only_process,
    remove_leftovers,
)
from scenarios.dataset.progress import MakeProgress
from scenarios.dataset.sequence_plan import (
    MakeRequest,
    plan_recipes,
    repeat_command,
    sequence_entry,
)
from scenarios.dataset.sequence_task import SequenceTask, library_versions, make_sequences
from scenarios.execute.local import worker_count
from sim.dataset.files.layout import (
    MANIFEST,
    PART,
)
from sim.dataset.files.manifest import manifest_record, write_manifest
from sim.files import disk_faults
from sim.processes import WorkerPool

# A worker is replaced after this many sequences: whatever a driver leaks goes with it.
SEQUENCES_A_WORKER = 64


def make_dataset(request: MakeRequest, workers: WorkerPool | None = None) -> None:
    """Make a data set, or go on with an unfinished one, and print its size.

    workers: a pool of the caller's, which stays open; without it `request.jobs` are started.
    Raises BenchError; Interrupted after a signal.
    """
    jobs = worker_count(request.jobs)
    recipes = plan_recipes(request)
    out = request.out.absolute()
    settings = {**request.labels.record(), "ladder": request.ladder}
    entries = [sequence_entry(index, recipe) for index, recipe in enumerate(recipes)]
    command = repeat_command(request)
    console = Console(stderr=True)
    with disk_faults(out, "the data set"):
        out.mkdir(parents=True, exist_ok=True)
    with only_process(out), interrupts() as arrived, arrived.raising():
        check_same_dataset(out, settings, entries)
        try:
            own = WorkerPool(jobs, SEQUENCES_A_WORKER, (make_sequences.__module__,))
            with own if workers is None else nullcontext(workers) as pool:
                made_with = {"renderer": pool.renderer(), "versions": library_versions()}
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
                started = time.perf_counter()
                with MakeProgress(console, tasks, frames) as progress:
                    written = make_sequences(pool, tasks, progress.step)
            remove_leftovers(out)  # of workers that were killed
            wall_s = time.perf_counter() - started
            finish_dataset(out, entries, settings, made_with, request.exports, command)
        except KeyboardInterrupt:
            remove_leftovers(out)
            done = sum((out / entry.folder).is_dir() for entry in entries)
            raise Interrupted(
                f"interrupted: {done} of {len(entries)} sequences are in {out}; the same command "
                "goes on"
            ) from None
        except BaseException:
            remove_leftovers(out)
            raise
    size = sum(sequence.bytes for sequence in written)
    summary = f"{count(len(tasks), 'sequence')}, {count(frames, 'stereo frame')}"
    if tasks:
        summary += f", {decimal(size)} in {wall_s:.0f} s ({frames / wall_s:.1f} frames/s)"
    kept = len(entries) - len(tasks)
    print(f"{summary}, {count(jobs, 'worker')}" + (f"; {kept} were there" if kept else ""))
    print(f"data set: {request.out}")
