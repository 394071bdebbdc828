"""A pool of worker processes that are isolated from each other and from the parent.

A killed worker is replaced, and its task done again. Pools of libraries share a queue and its lock
among their workers: a worker that is killed while it holds the lock stops all others.
"""

from __future__ import annotations

import ctypes
import multiprocessing
import os
import pickle
import signal
import threading
import time
import traceback
from collections import deque
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from multiprocessing import connection
from pathlib import Path
from types import TracebackType
from typing import Any, Generic, TypeVar

from pjpdaf.errors import BenchError, InfrastructureError
from pjpdaf.unforeseen import describe
from sim import steps
from sim.worker_server import END_LIMIT_S, TERMINAL_SIGNALS, fork_worker

ATTEMPTS = 3  # at a task whose worker is killed
POLL_S = 0.5
START_LIMIT_S = 300.0  # for a worker to start and to import what a task needs
SELF_TEST_LIMIT_S = 120.0
# One process a core: the software rasteriser's and the libraries' own threads only get in the way.
# LP_NUM_THREADS must stand before the first GL call; the pixels are the same for any value.
WORKER_ENVIRONMENT = {
    "LP_NUM_THREADS": "0",
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
}
TRIM_ABOVE_MB = 400.0  # of a worker after a task; a rendered episode keeps 360 at the most
STEPS_S = 0.2  # between two messages about the steps of a task
_BEGUN, _STEPS, _RETURNED, _RAISED = "begun", "steps", "returned", "raised"  # of a worker
T = TypeVar("T")
R = TypeVar("R")


@dataclass(frozen=True)
class Answer(Generic[R]):
    """The value that a task returned."""

    value: R


@dataclass(frozen=True)
class Lost:
    """A task without an answer.

    late: it exceeded its time limit; otherwise its worker was killed in each of `attempts`
    attempts, the last time with `exit_code`, None where that is not known.
    """

    late: bool
    attempts: int
    exit_code: int | None = None

    @property
    def death(self) -> str:
        """What happened to its worker, for messages; of a task that is not late."""
        code = "" if self.exit_code is None else f" (exit code {self.exit_code})"
        times = "once" if self.attempts == 1 else f"{self.attempts} times"
        return f"its worker died {times}{code}"


class WorkerPool:
    """A pool of `count` isolated worker processes; a context manager, which ends them at once.

    Each worker has a pipe of its own and shares no lock with others: when one is killed, the rest
    go on. After `close` it can be used again. tasks_per_worker: a worker is replaced after this
    many tasks; 0: never. modules: of ours, that workers which start from now on have imported,
    beside that of the function of their first task.
    """

    def __init__(
        self, count: int, tasks_per_worker: int = 0, modules: Collection[str] = ()
    ) -> None:
        for name, value in WORKER_ENVIRONMENT.items():
            os.environ.setdefault(name, value)
        self._count, self._tasks_per_worker = count, tasks_per_worker
        self.modules = tuple(modules)
        self._workers: list[_Worker] = []

    def outcomes(
        self,
        function: Callable[[T], R],
        tasks: Mapping[int, T],
        limit_s: float,
        attempts: int = ATTEMPTS,
    ) -> Iterator[tuple[int, Answer[R] | Lost] | None]:
        """Yield (index, outcome) of `function(task)` as tasks end, None on each poll.

        limit_s: time limit of one attempt, from the moment that a worker begins it; attempts: of a
        task whose worker is killed. Raises what `function` raises.
        """
        waiting, tried = deque(tasks), dict.fromkeys(tasks, 0)
        try:
            while waiting or any(worker.task_index is not None for worker in self._workers):
                for worker in self._idle_workers(len(waiting), function.__module__):
                    tried[waiting[0]] += 1
                    worker.assign(waiting[0], function, tasks[waiting.popleft()], limit_s)
                busy = [worker for worker in self._workers if worker.task_index is not None]
                connection.wait([worker.pipe for worker in busy], POLL_S)
                for worker in busy:
                    index, outcome = worker.task_index, worker.outcome()
                    assert index is not None
                    if outcome is None:
                        continue
                    if isinstance(outcome, Lost):
                        self._workers.remove(worker)
                        if not outcome.late and tried[index] < attempts:
                            waiting.append(index)
                            continue
                        outcome = replace(outcome, attempts=tried[index])
                    elif self._tasks_per_worker and worker.done >= self._tasks_per_worker:
                        self._workers.remove(worker)
                        worker.end()
                    yield index, outcome
                yield None
        finally:
            self._end_busy()  # where the caller or a task raised; else there are none

    def renderer(self) -> str:
        """The renderer's description, from the self-test in a worker.

        Raises InfrastructureError; not where a worker is killed from outside, as for want of
        memory: that is no fault of OpenGL's.
        """
        lost = Lost(late=False, attempts=0)
        for _ in range(ATTEMPTS):
            outcomes = self.outcomes(describe_renderer, {0: None}, SELF_TEST_LIMIT_S, attempts=1)
            outcome = next(indexed for indexed in outcomes if indexed is not None)[1]
            if isinstance(outcome, Answer):
                return outcome.value
            lost = outcome
            if lost.late or lost.exit_code != -signal.SIGKILL:
                break
        raise renderer_fault(lost)

    def renderers(self) -> frozenset[str]:
        """The description of the one renderer here. Raises as `renderer`."""
        return frozenset({self.renderer()})

    def running_steps(self) -> int:
        """The steps that the tasks in progress have counted (`sim.steps`), as of the last poll."""
        return sum(w.steps for w in tuple(self._workers) if w.task_index is not None)

    def close(self) -> None:
        """End all workers now, also those that are still starting or have a task."""
        workers, self._workers = self._workers, []
        _end_all(workers)

    def __enter__(self) -> WorkerPool:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        fault: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        # No worker has a task where all is well: there is nothing to wait for.
        self.close()

    def _end_busy(self) -> None:
        busy = [worker for worker in self._workers if worker.task_index is not None]
        self._workers = [worker for worker in self._workers if worker not in busy]
        _end_all(busy)

    def _idle_workers(self, most: int, module: str) -> list[_Worker]:
        """At most `most` workers without a task, started where there are too few."""
        for worker in [w for w in self._workers if w.task_index is None]:
            if worker.process.exit_code is not None:  # killed while it waited
                self._workers.remove(worker)
                worker.end()
        idle = [worker for worker in self._workers if worker.task_index is None]
        while len(idle) < most and len(self._workers) < self._count:
            idle.append(_Worker((*self.modules, module)))
            self._workers.append(idle[-1])
        return idle[:most]


class _Worker:
    """A process and the parent's end of its pipe.

    task_index: None without a task; steps: that its task has counted.
    """

    def __init__(self, modules: Collection[str]) -> None:
        self._pipe, theirs = multiprocessing.Pipe()
        with theirs:  # so that its end is known by the pipe's
            self.process = fork_worker(theirs, modules)
        self.task_index: int | None = None
        self.steps = 0
        self.done = 0
        self._limit_s = 0.0
        self._due = 0.0

    @property
    def pipe(self) -> Any:
        """For `multiprocessing.connection.wait`: ready with an answer, and at the end."""
        return self._pipe

    def assign(self, index: int, function: Callable[[T], R], task: T, limit_s: float) -> None:
        """Send a task. Its time limit starts when the worker has imported what it needs."""
        self.task_index, self.steps, self._limit_s = index, 0, limit_s
        self._due = time.monotonic() + START_LIMIT_S + limit_s
        with suppress(BrokenPipeError, ConnectionResetError):  # it ended; `outcome` says so
            self._pipe.send((function, task))

    def outcome(self) -> Answer[Any] | Lost | None:
        """The outcome of its task, None while it goes on. A lost worker is ended.

        Raises what the task raised.
        """
        alive = self.process.exit_code is None  # asked first: an answer may come before the end
        while self._pipe.poll():
            try:
                message, value = self._pipe.recv()
            except (EOFError, OSError, pickle.UnpicklingError):
                return self._end_lost(late=False)
            if message == _BEGUN:
                self._due = time.monotonic() + self._limit_s
                continue
            if message == _STEPS:
                self.steps = value
                continue
            self.task_index = None
            self.done += 1
            if message == _RAISED:
                raise value
            return Answer(value)
        if not alive:
            return self._end_lost(late=False)
        if time.monotonic() > self._due:
            return self._end_lost(late=True)
        return None

    def end(self) -> None:
        """Close its pipe, with which it ends, and remove the process."""
        self._pipe.close()
        self.process.join(END_LIMIT_S)
        if self.process.exit_code is None:
            self.process.kill()
            self.process.join()

    def _end_lost(self, late: bool) -> Lost:
        self.task_index = None
        if late:
            self.process.kill()
        self.process.join(END_LIMIT_S)
        code = self.process.exit_code
        self.end()
        return Lost(late, attempts=1, exit_code=code)


def _end_all(workers: Sequence[_Worker]) -> None:
    for worker in workers:
        worker.process.kill()
    for worker in workers:
        worker.end()


def serve(pipe: Any) -> None:
    """In a worker: answer each task, until the pipe is closed."""
    _prepare_worker()
    while True:
        try:
            function, task = pipe.recv()
        except EOFError:
            return
        pipe.send((_BEGUN, None))
        try:
            with steps.counting(_StepMessages(pipe).count):
                answer = _RETURNED, function(task)
        except Exception as fault:
            answer = _RAISED, sendable(fault)
        try:
            pipe.send(answer)
        except (AttributeError, TypeError, pickle.PicklingError) as fault:
            pipe.send((_RAISED, RuntimeError(f"its answer cannot be sent: {fault}")))
        del task, answer
        give_back_memory(TRIM_ABOVE_MB)


def give_back_memory(above_mb: float) -> None:
    """Give free memory back to the system where this process has more; nothing but on Linux.

    The C library keeps what is freed between blocks that stay: a third of a worker's memory.
    """
    with suppress(OSError, AttributeError):
        pages = int(Path("/proc/self/statm").read_text().split()[1])
        if pages * os.sysconf("SC_PAGE_SIZE") > above_mb * 1e6:
            ctypes.CDLL(None).malloc_trim(0)  # of glibc; others lack it


class _StepMessages:
    """Counts the steps of a task, and sends their number every `STEPS_S`."""

    def __init__(self, pipe: Any) -> None:
        self._pipe, self._steps, self._due = pipe, 0, 0.0

    def count(self) -> None:
        self._steps += 1
        now = time.monotonic()
        if now >= self._due:
            self._due = now + STEPS_S
            with suppress(OSError):  # the parent has ended, and so does this process
                self._pipe.send((_STEPS, self._steps))


def sendable(fault: Exception) -> Exception:
    """The exception as another process can read it; an unforeseen one tells where it was raised."""
    if isinstance(fault, BenchError):
        return fault
    fault.add_note("In a worker:\n" + "".join(traceback.format_exception(fault)))
    try:
        pickle.loads(pickle.dumps(fault))
    except Exception:  # pickle raises nearly anything, and so do the classes that it builds
        plain = RuntimeError(describe(fault))
        plain.__notes__ = fault.__notes__
        return plain
    return fault


def _prepare_worker() -> None:
    for number in TERMINAL_SIGNALS:
        signal.signal(number, signal.SIG_IGN)
    with suppress(OSError):  # where one is closed
        os.dup2(2, 1)  # what plug-ins print must not stand among the figures on standard output
    threading.Thread(target=_end_with_parent, daemon=True).start()
    import cv2

    cv2.setNumThreads(1)


def _end_with_parent() -> None:
    # However the parent ended (kill, a closed terminal), nobody waits for this task any more.
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def describe_renderer(_: None) -> str:
    """In a worker: the renderer's description, after the self-test. Raises InfrastructureError."""
    from sim import gl
    from sim.camera import selftest

    gl.prepare()
    selftest.check()
    return gl.describe()


def renderer_fault(lost: Lost) -> InfrastructureError:
    """The fault of a self-test without an answer."""
    if lost.late:
        return InfrastructureError(
            "OpenGL did not render one picture within 120 s; try MUJOCO_GL=osmesa"
        )
    return InfrastructureError(
        f"OpenGL ends the process (exit code {lost.exit_code}); see what `pjpdaf-bench doctor` says"
    )


def check_renderer() -> str:
    """Render the self-test in a new process; the renderer's description.

    Raises InfrastructureError where OpenGL is missing or renders in the wrong place.
    """
    with WorkerPool(1) as workers:
        return workers.renderer()
