"""The executor on this machine: a pool of worker processes."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager

from pjpdaf.errors import BenchError
from reports.summary.text import count
from scenarios.execute.executor import Executor
from sim.processes import WorkerPool

PLAYED_WITH = ("scenarios.execute.episodes",)  # imported once, before workers are forked
MAX_TIME_LIMIT_S = 86_400.0


def worker_count(jobs: int | None) -> int:
    """The number of workers for `--jobs`; None: as many as there are cores.

    Raises BenchError outside 1 .. max(32, 4 a core).
    """
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    cores = cores or 1
    most = max(32, 4 * cores)
    if jobs is None:
        return cores
    if not 1 <= jobs <= most:
        raise BenchError(
            f"--jobs must be between 1 and {most}, got {jobs}; this machine has "
            f"{count(cores, 'core')}"
        )
    return jobs


def check_time_limit(limit_s: float) -> None:
    """Raise BenchError for a `--time-limit` that no episode can have."""
    if not 0 < limit_s <= MAX_TIME_LIMIT_S:
        raise BenchError(
            f"--time-limit must be above 0 s, at most {MAX_TIME_LIMIT_S:g}, got {limit_s:g}"
        )


@contextmanager
def local_executor(workers: int, tasks_per_worker: int = 0) -> Iterator[Executor]:
    """An executor with this many worker processes, which end with the block.

    tasks_per_worker: as of `WorkerPool`.
    """
    with WorkerPool(workers, tasks_per_worker, PLAYED_WITH) as pool:
        yield pool
