"""Many episodes: a pool of local worker processes, isolated from each other and from the parent."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import TimeoutError as FutureTimeout
from concurrent.futures import wait
from contextlib import contextmanager
from dataclasses import dataclass, replace

from pebble import ProcessExpired, ProcessFuture, ProcessPool

from pjpdaf.errors import BenchError, InfrastructureError
from pjpdaf.registry import described
from reports.records import EpisodeFailure
from reports.results import films_to_keep
from reports.rows import EpisodeRows, rows_of
from scenarios.play import Job, digest_of, play
from scenarios.plugged import PlugInFault
from sim.contact import Unposable

EPISODE_TIME_LIMIT_S = 900.0
ATTEMPTS = 3  # only for killed workers: scores are never played again
# One process a core: the software rasteriser's and the libraries' own threads only get in the way.
# LP_NUM_THREADS must stand before the first GL call; the pixels are the same for any value.
WORKER_ENVIRONMENT = {
    "LP_NUM_THREADS": "0",
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
}


@dataclass(frozen=True)
class Played:
    """What came of a list of jobs; finished ones only, in the order of the jobs.

    renderer: "" where nothing was rendered.
    """

    rows: tuple[EpisodeRows, ...]
    interrupted: bool
    renderer: str


def _prepare_worker() -> None:
    # Ctrl-C reaches the whole process group; only the parent decides what happens then.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()
    import cv2

    cv2.setNumThreads(1)


def _end_with_parent() -> None:
    # However the parent ended (kill, a closed terminal), nobody waits for this episode any more.
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


@contextmanager
def _interrupt_deferred() -> Iterator[None]:
    """Ctrl-C waits until the block ends; processes and threads started in it never get it."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _check_renderer() -> str:
    from sim import gl, selftest

    gl.prepare()
    selftest.check()
    return gl.describe()


def _play_safely(job: Job) -> EpisodeRows | BenchError:
    """`play`, with what a user can put right returned, and any other fault as a failed episode."""
    try:
        return rows_of(play(job))
    except Unposable as fault:
        return _failure(job, f"cannot be posed: {fault}")
    except BenchError as fault:
        # Errors with fields of their own do not survive pickling; line and exit code suffice.
        kind = InfrastructureError if fault.exit_code == 5 else BenchError
        return kind(str(fault))
    except PlugInFault as fault:
        return _failure(job, str(fault))
    except (Exception, SystemExit, KeyboardInterrupt) as fault:
        # Of a plug-in, too: Ctrl-C does not reach a worker, and nothing of ours exits here.
        return _failure(job, described(fault))


def check_renderer() -> str:
    """Render the self-test in a process of its own; the renderer's description.

    Raises InfrastructureError where OpenGL is missing or renders in the wrong place.
    """
    with worker_pool(1) as pool:
        return renderer_of(pool)


def play_all(
    jobs: Sequence[Job],
    workers: int,
    on_done: Callable[[EpisodeRows], None] = lambda row: None,
    time_limit_s: float = EPISODE_TIME_LIMIT_S,
) -> Played:
    """Play all jobs on `workers` processes.

    A worker that dies is replaced and its episode played again, three times at most; an episode
    over its time limit, or that raises, becomes a failed episode. Ctrl-C ends the run and keeps
    what is finished. Neither the rows nor their order depend on `workers`.
    Raises BenchError (the first in the order of the jobs) where the user's input is at fault.
    OpenGL is needed only where a job is rendered.
    """
    results: dict[int, EpisodeRows] = {}
    attempts = [0] * len(jobs)
    pending: dict[ProcessFuture[EpisodeRows | BenchError], int] = {}
    interrupted = False
    with worker_pool(min(workers, len(jobs))) as pool:
        renderer = renderer_of(pool) if any(job.kept is None for job in jobs) else ""

        def submit(index: int) -> None:
            attempts[index] += 1
            future = pool.schedule(_play_safely, args=(jobs[index],), timeout=time_limit_s)
            pending[future] = index

        try:
            with _interrupt_deferred():  # the first task starts the workers
                for index in range(len(jobs)):
                    submit(index)
            while pending:
                done, _ = wait(pending, return_when="FIRST_COMPLETED")
                for future in done:
                    index = pending.pop(future)
                    outcome = _outcome(future, jobs[index], attempts[index], time_limit_s)
                    if outcome is None:
                        submit(index)
                        continue
                    results[index] = outcome
                    if outcome.film:
                        _drop_films(results)
                    on_done(outcome)
        except KeyboardInterrupt:
            interrupted = True
            pool.stop()
        except BaseException:
            pool.stop()
            raise
    return Played(tuple(results[i] for i in sorted(results)), interrupted, renderer)


def _outcome(
    future: ProcessFuture[EpisodeRows | BenchError], job: Job, attempt: int, time_limit_s: float
) -> EpisodeRows | None:
    """A finished future as an outcome; None: the worker died and the job may be tried again."""
    try:
        result: EpisodeRows | BenchError = future.result()
    except FutureTimeout:
        return _failure(
            job, f"not finished within {time_limit_s:.0f} s; --time-limit gives it more"
        )
    except ProcessExpired as death:
        if attempt < ATTEMPTS:
            return None
        return _failure(job, f"its worker died {attempt} times (exit code {death.exitcode})")
    if isinstance(result, BenchError):
        raise result
    return result


def _drop_films(results: dict[int, EpisodeRows]) -> None:
    """Forget films that will not be saved: all of them together would not fit into memory."""
    kept = films_to_keep(list(results.values()))
    for index, row in results.items():
        if row.film and (row.scenario, row.seed) not in kept:
            results[index] = replace(row, film=())


def _failure(job: Job, reason: str) -> EpisodeRows:
    scenario = job.scenario
    failure = EpisodeFailure(job.name, job.seed, reason, scenario.group, digest_of(job))
    return rows_of(failure)


def worker_pool(workers: int, tasks_each: int = 0) -> ProcessPool:
    """A pool of processes that can render; close it or use `with`.

    tasks_each: a worker is replaced after so many tasks; 0: never.
    """
    # Spawn, always: a child forked beside a GL context hangs.
    for name, value in WORKER_ENVIRONMENT.items():
        os.environ.setdefault(name, value)
    return ProcessPool(
        max_workers=workers,
        max_tasks=tasks_each,
        initializer=_prepare_worker,
        context=multiprocessing.get_context("spawn"),
    )


def renderer_of(pool: ProcessPool) -> str:
    """The renderer's description, from the self-test in a worker. Raises InfrastructureError."""
    try:
        with _interrupt_deferred():  # the first task starts the workers
            future = pool.schedule(_check_renderer, timeout=120)
        described: str = future.result()
    except FutureTimeout as fault:
        pool.stop()
        raise InfrastructureError(
            "OpenGL did not render one picture within 120 s; try MUJOCO_GL=osmesa"
        ) from fault
    except ProcessExpired as fault:
        pool.stop()
        raise InfrastructureError(
            f"OpenGL ends the process (exit code {fault.exitcode}); "
            "see what `pjpdaf-bench doctor` says"
        ) from fault
    except BaseException:
        pool.stop()
        for worker in multiprocessing.active_children():
            worker.kill()  # one that is still starting would print what it misses
        raise
    return described
