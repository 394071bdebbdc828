"""In a worker of Dask: tasks in isolated processes of our own, which are kept between tasks.

What hangs or crashes ends its isolated process alone, and a time limit can be kept: Dask itself
ends no task. The Dask worker imports nothing large, and sees tasks and answers as bytes only.
"""

from __future__ import annotations

import functools
import multiprocessing
import multiprocessing.util
import pickle
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

from sim.processes import Answer, Lost, WorkerPool, sendable

if TYPE_CHECKING:
    from scenarios.execute.software import PlugIns

IDLE_S = 60.0  # then an isolated process without tasks ends
CHECK_S = 5.0


@dataclass(frozen=True)
class Sender:
    """Who sends tasks. software, plug_ins: as in `scenarios.execute.software`."""

    software: tuple[tuple[str, str], ...]
    plug_ins: PlugIns


@dataclass(frozen=True)
class Parcel:
    """A task on its way to a worker.

    run: name of the batch that it belongs to; module: of the function; work: function and argument,
    pickled; sender: pickled; limit_s, attempts: as of `Executor.outcomes`; tasks_per_worker: as of
    `WorkerPool`.
    """

    run: str
    module: str
    work: bytes
    sender: bytes
    limit_s: float
    attempts: int
    tasks_per_worker: int


@dataclass(frozen=True)
class Reply:
    """What an isolated process says of a parcel.

    payload: the value or the exception, pickled; of a refusal, the differences of the software.
    """

    kind: Literal["returned", "raised", "refused"]
    payload: bytes


def packed(function: Callable[[Any], Any], task: Any) -> bytes:
    """The work of a parcel."""
    return pickle.dumps((function, task))


def perform(parcel: bytes) -> Answer[Reply] | Lost | None:
    """Perform a pickled parcel in an isolated process; None where its batch was ended."""
    task: Parcel = pickle.loads(parcel)
    modules = (task.module,) if task.sender in _equal else ()  # else it may lack a library
    with _POOLS.leased(task.tasks_per_worker, modules) as pool:
        tasks: Mapping[int, Any] = {0: _Delivered(task)}
        outcomes = pool.outcomes(_reply, tasks, task.limit_s, task.attempts)
        for outcome in outcomes:
            if outcome is not None:
                answer = outcome[1]
                if isinstance(answer, Answer) and answer.value.kind != "refused":
                    _equal.add(task.sender)
                return answer
            if task.run in _ended:
                pool.close()
                return None
    raise AssertionError("a task has an outcome")


def end_run(run: str) -> None:
    """End the tasks of a batch: nobody waits for them any more."""
    _ended.add(run)


def do_nothing(_: None) -> None:
    """A task that shows that a worker works."""


_ended: set[str] = set()
_equal: set[bytes] = set()  # senders whose software is that of this worker


class _Delivered:
    """A parcel on its way into an isolated process, where it arrives as an `_Opened`.

    It is opened while it is unpickled, as the tasks of a local pool are: the time limit is of the
    work alone, not of imports.
    """

    def __init__(self, parcel: Parcel) -> None:
        self._parcel = parcel

    def __reduce__(self) -> tuple[Any, ...]:
        return _opened, (self._parcel,)


@dataclass(frozen=True)
class _Opened:
    """A function and its argument, or why there is none."""

    function: Callable[[Any], Any]
    task: Any
    fault: Reply | None = None


def _opened(parcel: Parcel) -> _Opened:
    differences = _differences(parcel.sender)
    if differences:
        return _Opened(str, None, Reply("refused", differences.encode()))
    try:
        return _Opened(*pickle.loads(parcel.work))
    except Exception as fault:
        return _Opened(str, None, _raised(fault))


def _reply(opened: _Opened) -> Reply:
    """In an isolated process: the reply of a task."""
    if opened.fault is not None:
        return opened.fault
    try:
        return Reply("returned", pickle.dumps(opened.function(opened.task)))
    except Exception as fault:
        return _raised(fault)


def _raised(fault: Exception) -> Reply:
    return Reply("raised", pickle.dumps(sendable(fault)))


@functools.cache
def _differences(sender: bytes) -> str:
    # Here, not above: the Dask worker stays small, and can say that it lacks a library.
    from scenarios.execute.software import differences, software

    record: Sender = pickle.loads(sender)
    return differences(software(record.plug_ins), dict(record.software))


class _Pools:
    """Pools of an isolated process each, as many as there are tasks at the same time."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._idle: list[tuple[float, int, WorkerPool]] = []  # the longest unused first
        self._busy: list[WorkerPool] = []
        self._reaper: threading.Thread | None = None

    @contextmanager
    def leased(self, tasks_per_worker: int, modules: tuple[str, ...]) -> Iterator[WorkerPool]:
        """A pool that nobody else uses, until the block ends. modules: as of `WorkerPool`."""
        pool = self._taken(tasks_per_worker)
        pool.modules = modules
        try:
            yield pool
        finally:
            with self._lock:
                self._busy.remove(pool)
                self._idle.append((time.monotonic(), tasks_per_worker, pool))
                if self._reaper is None:
                    self._reaper = threading.Thread(target=self._end_idle, daemon=True)
                    self._reaper.start()

    def _taken(self, tasks_per_worker: int) -> WorkerPool:
        with self._lock:
            _may_have_children()
            fitting = [entry for entry in self._idle if entry[1] == tasks_per_worker]
            if fitting:
                self._idle.remove(fitting[-1])
                pool = fitting[-1][2]
            else:
                pool = WorkerPool(1, tasks_per_worker)
            self._busy.append(pool)
            return pool

    def _end_idle(self) -> None:
        while True:
            time.sleep(CHECK_S)
            with self._lock:
                old = [e for e in self._idle if time.monotonic() - e[0] > IDLE_S]
                self._idle = [entry for entry in self._idle if entry not in old]
                if not self._idle and not self._busy:
                    self._reaper = None
                done = self._reaper is None
            for _, _, pool in old:
                pool.close()
            if done:
                return

    def close(self) -> None:
        """End all isolated processes."""
        with self._lock:
            pools = [*(pool for _, _, pool in self._idle), *self._busy]
            self._idle = []
        for pool in pools:
            pool.close()


@functools.cache
def _may_have_children() -> None:
    """Let this process start others, and end them when it ends.

    A nanny of Dask marks its worker as one that has no children; that is there to have no orphans,
    and ours end with their parent however it ends.
    """
    multiprocessing.current_process().daemon = False
    # Before Python waits for the children, which wait for tasks.
    multiprocessing.util.Finalize(None, _POOLS.close, exitpriority=1)


_POOLS = _Pools()
