"""Worker processes that render, isolated from each other and from the parent.

A worker that is killed is replaced, and its task done again. Pools of libraries share a queue and
its lock among their workers: one that is killed with it in hand stops them all.
"""

from __future__ import annotations

import multiprocessing
import os
import pickle
import signal
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from multiprocessing import connection
from types import TracebackType
from typing import Any, Generic, TypeVar

from pjpdaf.errors import InfrastructureError

ATTEMPTS = 3  # of a task whose worker is killed
POLL_S = 0.5
END_LIMIT_S = 5.0  # for a worker to end by itself
SELF_TEST_LIMIT_S = 120.0
# One process a core: the software rasteriser's and the libraries' own threads only get in the way.
# LP_NUM_THREADS must stand before the first GL call; the pixels are the same for any value.
WORKER_ENVIRONMENT = {
    "LP_NUM_THREADS": "0",
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
}
# Ctrl-C and a closed terminal reach the whole process group: only the parent decides about them.
TERMINAL_SIGNALS = (signal.SIGINT, signal.SIGHUP)
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

    Each has a pipe of its own and no lock with others: whenever one is killed, the rest go on.
    tasks_each: a worker is replaced after so many tasks, 0: never.
    """

    def __init__(self, count: int, tasks_each: int = 0) -> None:
        for name, value in WORKER_ENVIRONMENT.items():
            os.environ.setdefault(name, value)
        self._count, self._tasks_each = count, tasks_each
        self._workers: list[_Worker] = []

    def outcomes(
        self,
        function: Callable[[T], R],
        tasks: Mapping[int, T],
        limit_s: float,
        attempts: int = ATTEMPTS,
    ) -> Iterator[tuple[int, Answer[R] | Lost] | None]:
        """`function` of every task, as they end, by number; None now and then while waiting.

        limit_s: of one attempt; attempts: of a task whose worker is killed. An exception of
        `function` comes out here.
        """
        waiting, tried = deque(tasks), dict.fromkeys(tasks, 0)
        while waiting or any(worker.number is not None for worker in self._workers):
            for worker in self._free(len(waiting)):
                tried[waiting[0]] += 1
                worker.give(waiting[0], function, tasks[waiting.popleft()])
            busy = [worker for worker in self._workers if worker.number is not None]
            connection.wait([handle for one in busy for handle in one.handles], POLL_S)
            for worker in busy:
                number, said = worker.number, worker.answer(limit_s)
                assert number is not None
                if said is None:
                    continue
                if isinstance(said, Lost):
                    self._workers.remove(worker)
                    if not said.late and tried[number] < attempts:
                        waiting.append(number)
                        continue
                    said = replace(said, attempts=tried[number])
                elif self._tasks_each and worker.done >= self._tasks_each:
                    self._workers.remove(worker)
                    worker.end()
                yield number, said
            yield None

    def renderer(self) -> str:
        """The renderer's description, from the self-test in a worker. Raises InfrastructureError.

        A worker that is killed from outside (as for want of memory) is no fault of OpenGL's.
        """
        code = None
        for _ in range(ATTEMPTS):
            found = self.outcomes(_check_renderer, {0: None}, SELF_TEST_LIMIT_S, attempts=1)
            said = next(one for one in found if one is not None)[1]
            if isinstance(said, Answer):
                return said.value
            if said.late:
                raise InfrastructureError(
                    "OpenGL did not render one picture within 120 s; try MUJOCO_GL=osmesa"
                )
            code = said.exit_code
            if code != -signal.SIGKILL:
                break
        raise InfrastructureError(
            f"OpenGL ends the process (exit code {code}); see what `pjpdaf-bench doctor` says"
        )

    def stop(self) -> None:
        """End all workers now, also those that are still starting."""
        for worker in self._workers:
            worker.process.kill()
        for worker in self._workers:
            worker.end()
        self._workers = []

    def __enter__(self) -> Workers:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        fault: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        # No worker has a task where all is well: there is nothing to wait for.
        self.stop()

    def _free(self, wanted: int) -> list[_Worker]:
        """So many workers without a task, started where there are too few."""
        for worker in [w for w in self._workers if w.number is None]:
            if not worker.process.is_alive():  # killed while it waited
                self._workers.remove(worker)
                worker.end()
        free = [worker for worker in self._workers if worker.number is None]
        while len(free) < wanted and len(self._workers) < self._count:
            free.append(_Worker())
            self._workers.append(free[-1])
        return free[:wanted]


class _Worker:
    """A process and its end of a pipe. number: of the task that it does, None without one."""

    def __init__(self) -> None:
        # Spawn, always: a child forked beside a GL context hangs.
        spawn = multiprocessing.get_context("spawn")
        self._pipe, theirs = spawn.Pipe()
        self.process = spawn.Process(target=_serve, args=(theirs,))
        with _terminal_signals_blocked():
            self.process.start()
        theirs.close()  # so that its end is known by the pipe's
        self.number: int | None = None
        self.done = 0
        self._since = 0.0

    @property
    def handles(self) -> tuple[Any, int]:
        """What `multiprocessing.connection.wait` takes: ready with an answer, and with its end."""
        return self._pipe, self.process.sentinel

    def give(self, number: int, function: Callable[[T], R], task: T) -> None:
        """Begin a task."""
        self.number, self._since = number, time.monotonic()
        with suppress(BrokenPipeError, ConnectionResetError):  # it ended; `answer` will say so
            self._pipe.send((function, task))

    def answer(self, limit_s: float) -> Answer[Any] | Lost | None:
        """What became of its task, None while it goes on. A lost worker is ended.

        Raises what the task raised.
        """
        alive = self.process.is_alive()  # asked first: an answer may come just before the end
        if self._pipe.poll():
            try:
                fine, value = self._pipe.recv()
            except (EOFError, OSError, pickle.UnpicklingError):
                return self._lost(late=False)
            self.number = None
            self.done += 1
            if not fine:
                raise value
            return Answer(value)
        if not alive:
            return self._lost(late=False)
        if time.monotonic() - self._since > limit_s:
            return self._lost(late=True)
        return None

    def end(self) -> None:
        """Let it go: without its pipe it ends, and its remains are taken away."""
        self._pipe.close()
        self.process.join(END_LIMIT_S)
        if self.process.exitcode is None:
            self.process.kill()
            self.process.join()
        self.process.close()

    def _lost(self, late: bool) -> Lost:
        self.number = None
        if late:
            self.process.kill()
        self.process.join(END_LIMIT_S)
        code = self.process.exitcode
        self.end()
        return Lost(late, attempts=1, exit_code=code)


def _serve(pipe: Any) -> None:
    """In a worker: answer each task, until the pipe is closed."""
    _prepare_worker()
    while True:
        try:
            function, task = pipe.recv()
        except EOFError:
            return
        try:
            answer = True, function(task)
        except Exception as fault:
            answer = False, fault
        try:
            pipe.send(answer)
        except (AttributeError, TypeError, pickle.PicklingError) as fault:
            pipe.send((False, RuntimeError(f"its answer cannot be sent: {fault}")))


def _prepare_worker() -> None:
    for number in TERMINAL_SIGNALS:
        signal.signal(number, signal.SIG_IGN)
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
def _terminal_signals_blocked() -> Iterator[None]:
    """Block `TERMINAL_SIGNALS`, also in the processes that are started in the block."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, TERMINAL_SIGNALS)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _check_renderer(_: None) -> str:
    from sim import gl
    from sim.camera import selftest

    gl.prepare()
    selftest.check()
    return gl.describe()


def check_renderer() -> str:
    """Render the self-test in a process of its own; the renderer's description.

    Raises InfrastructureError where OpenGL is missing or renders in the wrong place.
    """
    with Workers(1) as workers:
        return workers.renderer()
