"""Worker processes that render, isolated from each other and from the parent.

A worker that is killed is replaced, and its task done again; a pool that breaks with it is made
anew.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import CancelledError, wait
from concurrent.futures import TimeoutError as FutureTimeout
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass
from types import TracebackType
from typing import Generic, TypeVar

from pebble import ProcessExpired, ProcessFuture, ProcessPool

from pjpdaf.errors import InfrastructureError

ATTEMPTS = 3  # of a task whose worker is killed
RENEWALS = 20  # of a broken pool
POLL_S = 0.5
SELF_TEST_LIMIT_S = 120.0
# One process a core: the software rasteriser's and the libraries' own threads only get in the way.
# LP_NUM_THREADS must stand before the first GL call; the pixels are the same for any value.
WORKER_ENVIRONMENT = {
    "LP_NUM_THREADS": "0",
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
}
T = TypeVar("T")
R = TypeVar("R")


@dataclass(frozen=True)
class Answer(Generic[R]):
    """What a task returned."""

    value: R


@dataclass(frozen=True)
class Lost:
    """A task without an answer. late: it took longer than its limit; else its worker was killed
    in each of `attempts` attempts, the last time with this exit code.
    """

    late: bool
    attempts: int
    exit_code: int | None = None


class Workers:
    """So many worker processes. Use it with `with`; an exception inside ends them at once.

    tasks_each: a worker is replaced after so many tasks, 0: never.
    """

    def __init__(self, count: int, tasks_each: int = 0) -> None:
        # Spawn, always: a child forked beside a GL context hangs.
        for name, value in WORKER_ENVIRONMENT.items():
            os.environ.setdefault(name, value)
        self._count, self._tasks_each, self._renewals = count, tasks_each, 0
        self._others = {child.pid for child in multiprocessing.active_children()}
        self._pool = self._new()

    def outcomes(
        self, function: Callable[[T], R], tasks: Mapping[int, T], limit_s: float
    ) -> Iterator[tuple[int, Answer[R] | Lost] | None]:
        """`function` of every task, as they end, by number; None now and then while waiting.

        limit_s: of one attempt. An exception of `function` comes out here.
        """
        attempts = dict.fromkeys(tasks, 0)
        pending: dict[ProcessFuture[R], int] = {}
        waiting = list(tasks)
        while waiting or pending:
            while waiting:
                attempts[waiting[0]] += 1
                future = self._schedule(function, tasks[waiting[0]], limit_s)
                if future is None:  # the pool broke; what it held is done again
                    waiting += pending.values()
                    pending.clear()
                else:
                    pending[future] = waiting.pop(0)
            done, _ = wait(pending, timeout=POLL_S, return_when="FIRST_COMPLETED")
            for future in done:
                number = pending.pop(future)
                try:
                    outcome: Answer[R] | Lost = Answer(future.result())
                except FutureTimeout:
                    outcome = Lost(late=True, attempts=attempts[number])
                except (ProcessExpired, BrokenProcessPool, CancelledError) as death:
                    if attempts[number] < ATTEMPTS:
                        waiting.append(number)
                        continue
                    code = getattr(death, "exitcode", None)
                    outcome = Lost(late=False, attempts=attempts[number], exit_code=code)
                yield number, outcome
            if not self._pool.active:
                waiting += pending.values()
                pending.clear()
                self._renew()
            yield None

    def renderer(self) -> str:
        """The renderer's description, from the self-test in a worker. Raises InfrastructureError.

        A worker that is killed from outside (as for want of memory) is no fault of OpenGL's.
        """
        for attempt in range(1, ATTEMPTS + 1):
            future = self._schedule(_check_renderer, None, SELF_TEST_LIMIT_S)
            try:
                if future is not None:
                    described: str = future.result()
                    return described
            except FutureTimeout as fault:
                raise InfrastructureError(
                    "OpenGL did not render one picture within 120 s; try MUJOCO_GL=osmesa"
                ) from fault
            except BrokenProcessPool:
                self._renew()
            except ProcessExpired as fault:
                if fault.exitcode != -signal.SIGKILL or attempt == ATTEMPTS:
                    raise InfrastructureError(
                        f"OpenGL ends the process (exit code {fault.exitcode}); "
                        "see what `pjpdaf-bench doctor` says"
                    ) from fault
        raise InfrastructureError("worker processes end as soon as they start")

    def stop(self) -> None:
        """End all workers now, also those that are still starting."""
        self._pool.stop()
        for worker in multiprocessing.active_children():
            if worker.pid not in self._others:
                worker.kill()  # one that is still starting would print what it misses
        self._pool.join()

    def __enter__(self) -> Workers:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        fault: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if kind is not None:
            self.stop()
        else:
            self._pool.close()
            self._pool.join()

    def _new(self) -> ProcessPool:
        return ProcessPool(
            max_workers=self._count,
            max_tasks=self._tasks_each,
            initializer=_prepare_worker,
            context=multiprocessing.get_context("spawn"),
        )

    def _renew(self) -> None:
        """A new pool for a broken one. Raises InfrastructureError where that goes on and on."""
        self.stop()
        self._renewals += 1
        if self._renewals > RENEWALS:
            raise InfrastructureError(
                f"worker processes were killed {RENEWALS} times; try fewer --jobs"
            )
        self._pool = self._new()

    def _schedule(
        self, function: Callable[[T], R], task: T, limit_s: float
    ) -> ProcessFuture[R] | None:
        """None: the pool was broken, and is another now."""
        try:
            with _interrupt_deferred():  # the first task starts the workers
                future: ProcessFuture[R] = self._pool.schedule(
                    function, args=(task,), timeout=limit_s
                )
        except RuntimeError:
            self._renew()
            return None
        return future


def _prepare_worker() -> None:
    # Ctrl-C reaches the whole process group; only the parent decides what happens then.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()
    import cv2

    cv2.setNumThreads(1)


def _end_with_parent() -> None:
    # However the parent ended (kill, a closed terminal), nobody waits for this task any more.
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


def _check_renderer(_: None) -> str:
    from sim import gl, selftest

    gl.prepare()
    selftest.check()
    return gl.describe()


def check_renderer() -> str:
    """Render the self-test in a process of its own; the renderer's description.

    Raises InfrastructureError where OpenGL is missing or renders in the wrong place.
    """
    with Workers(1) as workers:
        return workers.renderer()
