"""The executor on a cluster: Dask carries tasks to its workers, answers come back as they end.

Of Dask only futures are used. Each task is executed by `scenarios.execute.cluster_worker`. The
scheduler is trusted: whoever can talk to it can execute code on workers and on this machine.
"""

from __future__ import annotations

import functools
import os
import pickle
import queue
import time
import uuid
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from typing import Any, TypeVar

import distributed
from distributed.client import FutureCancelledError
from rich.console import Console

from pjpdaf import entry
from pjpdaf.errors import BenchError, InfrastructureError
from pjpdaf.printable import printable
from scenarios.execute.cluster_worker import Parcel, Reply, Sender, do_nothing, packed
from scenarios.execute.dask_client import (
    END_S,
    client_of,
    local_cluster,
    silent_loggers,
    within,
)
from scenarios.execute.executor import ClusterFault, Executor
from scenarios.execute.place import EXTRA, Place
from scenarios.execute.software import PlugIns, software
from sim.processes import (
    ATTEMPTS,
    POLL_S,
    SELF_TEST_LIMIT_S,
    Answer,
    Lost,
    describe_renderer,
    renderer_fault,
)

WORKER_WAIT_VARIABLE = "PJPDAF_BENCH_WORKER_WAIT_S"
WORKER_WAIT_S = 60.0  # for a first worker; and for another one, where the last has gone
ASK_EVERY_S = 5.0  # whether scheduler and workers are still there
ANSWER_S = 60.0  # for the scheduler to answer
START_S = 300.0  # for a worker to start an isolated process and to import what it needs
BATCH = 100  # tasks in one message
AHEAD = 32  # tasks that wait at the scheduler, beside two for each thread of a worker
_WORKER = "scenarios.execute.cluster_worker"
T = TypeVar("T")
R = TypeVar("R")


@contextmanager
def cluster_executor(
    place: Place, plug_ins: PlugIns, tasks_per_worker: int = 0
) -> Iterator[Executor]:
    """An executor on a cluster; one that is started here ends with the block.

    Raises InfrastructureError where there is no scheduler or worker, BenchError where a worker has
    other software than this process.
    """
    wait_s = worker_wait_s()
    with ExitStack() as opened:
        opened.enter_context(silent_loggers())
        address: Any = place.scheduler
        if address == "local":
            address = opened.enter_context(local_cluster(place.workers))
        client = opened.enter_context(client_of(address))
        executor = ClusterExecutor(client, plug_ins, tasks_per_worker, wait_s)
        opened.callback(executor.close)
        executor.check_workers()
        yield executor


class ClusterExecutor:
    """Executes tasks on the workers of a Dask client.

    A task whose worker of Dask dies is done again elsewhere, as often as the scheduler allows
    (`distributed.scheduler.allowed-failures`). Raises ClusterFault where the scheduler goes, or no
    worker is left for `wait_s`.
    """

    def __init__(
        self, client: Any, plug_ins: PlugIns, tasks_per_worker: int, wait_s: float
    ) -> None:
        self._client, self._wait_s = client, wait_s
        self._tasks_per_worker = tasks_per_worker
        self._sender = pickle.dumps(Sender(tuple(software(plug_ins).items()), plug_ins))
        self._address = str(client.scheduler.address)
        self._threads = 0
        self._asked = self._had_workers = time.monotonic()

    def outcomes(
        self,
        function: Callable[[T], R],
        tasks: Mapping[int, T],
        limit_s: float,
        attempts: int = ATTEMPTS,
    ) -> Iterator[tuple[int, Answer[R] | Lost] | None]:
        """As of `Executor`."""
        run = uuid.uuid4().hex
        waiting = deque(tasks)
        flying: dict[str, int] = {}  # index of the task by the key of its future
        futures: dict[str, Any] = {}
        ended: queue.SimpleQueue[Any] = queue.SimpleQueue()
        try:
            while waiting or flying:
                self._check()
                while waiting and len(flying) < 2 * self._threads + AHEAD:
                    indices = [waiting.popleft() for _ in range(min(BATCH, len(waiting)))]
                    parcels = [
                        self._parcel(run, function, tasks[i], limit_s, attempts) for i in indices
                    ]
                    submitted = self._submit(run, indices, parcels)
                    for index, future in zip(indices, submitted, strict=True):
                        flying[future.key], futures[future.key] = index, future
                        future.add_done_callback(ended.put)
                for key, reply in self._replies(_drained(ended, POLL_S)):
                    del futures[key]
                    yield flying.pop(key), _outcome(reply)
                yield None
        finally:
            if futures:  # the caller or a task raised
                self._end(run, [*futures.values()])

    def check_workers(self) -> None:
        """Wait for a worker, and compare the software of all.

        Raises InfrastructureError without any, BenchError for other software.
        """
        self._wait_for_workers()
        for worker, outcome in self._ask_all(do_nothing, 1.0).items():
            if isinstance(outcome, Lost):
                raise InfrastructureError(f"worker {worker}: cannot start a process of its own")

    def renderers(self) -> frozenset[str]:
        """Descriptions of the OpenGL renderers of all workers. Raises InfrastructureError."""
        named = self._ask_all(describe_renderer, SELF_TEST_LIMIT_S)
        for worker, outcome in named.items():
            if isinstance(outcome, Lost):
                raise InfrastructureError(f"worker {worker}: {renderer_fault(outcome)}")
        return frozenset(o.value for o in named.values() if isinstance(o, Answer))

    def running_steps(self) -> int:
        """0: the workers of a cluster report a task when it has ended."""
        return 0

    def close(self) -> None:
        """Leave the cluster: its tasks of ours are ended."""
        if self._client.status == "running":
            with suppress(Exception):
                within(END_S, lambda: self._client.close(timeout=END_S))

    def _parcel(
        self, run: str, function: Callable[[T], R], task: T, limit_s: float, attempts: int
    ) -> bytes:
        module, work = function.__module__, packed(function, task)
        per_worker = self._tasks_per_worker
        return pickle.dumps(Parcel(run, module, work, self._sender, limit_s, attempts, per_worker))

    def _submit(self, run: str, indices: Sequence[int], parcels: Sequence[bytes]) -> Any:
        keys = [f"pjpdaf-{run}-{index}" for index in indices]
        perform = functools.partial(entry.call, _WORKER, "perform")
        with self._faults():
            return self._client.map(perform, parcels, key=keys, pure=False)

    def _replies(self, ended: Sequence[Any]) -> Iterator[tuple[str, Any]]:
        """Yield (key, reply) of futures that have ended."""
        if not ended:
            return
        with self._faults():
            whole = [future for future in ended if future.status == "finished"]
            try:
                values = dict(zip((f.key for f in whole), self._client.gather(whole), strict=True))
            except Exception:  # one of them was lost with its worker, and failed when done again
                values = {}
        for future in ended:
            if future.key not in values:
                values[future.key] = self._reply(future)
            yield future.key, values[future.key]

    def _reply(self, future: Any) -> Any:
        try:
            with self._faults():
                return future.result()
        except distributed.KilledWorker as fault:
            return Lost(late=False, attempts=fault.allowed_failures + 1)

    def _check(self) -> None:
        """Count the threads of the workers from time to time. Raises ClusterFault."""
        now = time.monotonic()
        if self._client.status != "running":
            raise self._gone()
        if self._threads and now - self._asked < ASK_EVERY_S:
            return
        self._asked = now
        with self._faults():
            ask = self._client.scheduler.ncores
            self._threads = sum(self._client.sync(ask, callback_timeout=ANSWER_S).values())
        if self._threads:
            self._had_workers = now
        elif now - self._had_workers > self._wait_s:
            raise ClusterFault(f"{self._address}: no worker was left for {self._wait_s:g} s")

    def _wait_for_workers(self) -> None:
        said = False
        self._had_workers = time.monotonic()
        while not self._threads:
            try:
                self._check()
            except ClusterFault as fault:
                if self._client.status != "running":
                    raise
                raise InfrastructureError(
                    f"no worker has joined the scheduler {self._address} within {self._wait_s:g} s",
                    f"start some: dask worker {self._address}",
                ) from fault
            if not self._threads:
                if not said:
                    Console(stderr=True).print(f"waiting for workers of {self._address}")
                said = True
                time.sleep(POLL_S)

    def _ask_all(
        self, function: Callable[[None], R], limit_s: float
    ) -> dict[str, Answer[R] | Lost]:
        """The outcome of `function(None)` on each worker that lives. Raises BenchError."""
        parcel = self._parcel("", function, None, limit_s, ATTEMPTS)
        ask = functools.partial(
            self._client.run, entry.call_aside, _WORKER, "perform", parcel, on_error="return"
        )
        try:
            with self._faults():
                replies = within(START_S + limit_s, ask)
        except TimeoutError:
            raise InfrastructureError(
                f"a worker of {self._address} gives no answer within {START_S + limit_s:g} s"
            ) from None
        outcomes = {}
        for worker, reply in replies.items():
            if isinstance(reply, OSError):  # the worker has gone; another may take its place
                continue
            if isinstance(reply, Exception):
                raise _fault_of_worker(worker, reply)
            outcomes[worker] = _outcome(reply, worker)
        if replies and not outcomes:
            raise InfrastructureError(f"all workers of {self._address} have gone")
        return outcomes

    def _end(self, run: str, futures: Sequence[Any]) -> None:
        """End tasks that nobody waits for."""
        if self._client.status != "running":
            return
        with suppress(Exception):
            within(END_S, lambda: self._client.cancel(futures, force=True))
            tell = functools.partial(
                self._client.run, entry.call, _WORKER, "end_run", run, on_error="ignore"
            )
            within(END_S, tell)

    @contextmanager
    def _faults(self) -> Iterator[None]:
        """Turn what Dask raises into a ClusterFault where the scheduler has gone."""
        try:
            yield
        except (FutureCancelledError, OSError) as fault:
            raise self._gone() from fault
        except (ImportError, AttributeError) as fault:  # of a function that is not there
            raise _fault_of_worker("", fault) from fault

    def _gone(self) -> ClusterFault:
        return ClusterFault(f"the Dask scheduler {self._address} has gone or does not answer")


def worker_wait_s(environment: Mapping[str, str] = os.environ) -> float:
    """How long to wait for workers, from the environment. Raises BenchError."""
    text = environment.get(WORKER_WAIT_VARIABLE, "") or str(WORKER_WAIT_S)
    try:
        wait_s = float(text)
    except ValueError:
        wait_s = -1.0
    if not 0 < wait_s <= 1e6:
        raise BenchError(f"{WORKER_WAIT_VARIABLE} must be above 0, at most 1e6, got {text[:40]!r}")
    return wait_s


def _outcome(reply: Any, worker: str = "") -> Any:
    """The outcome of a task by what a worker replied. Raises what the task raised."""
    if isinstance(reply, Lost):
        return reply
    if not (isinstance(reply, Answer) and isinstance(reply.value, Reply)):
        raise ClusterFault("another process ended a task of this run on its worker")
    answer = reply.value
    if answer.kind == "refused":
        named = f"worker {worker}" if worker else "a worker"
        raise BenchError(
            f"{named} has other software than this process: {answer.payload.decode()}; install the "
            "same there, and start it anew"
        )
    value = pickle.loads(answer.payload)
    if answer.kind == "raised":
        raise value
    return Answer(value)


def _fault_of_worker(worker: str, fault: Exception) -> BenchError:
    named = f"worker {worker}" if worker else "scheduler or worker"
    return BenchError(
        f"{named}: cannot execute tasks of pjpdaf-bench: {printable(str(fault))}; install there "
        f"what is installed here, and start it anew: {EXTRA}"
    )


def _drained(ended: queue.SimpleQueue[Any], wait_s: float) -> list[Any]:
    """All that is in a queue; waits for the first."""
    found = []
    with suppress(queue.Empty):
        found.append(ended.get(timeout=wait_s))
        while True:
            found.append(ended.get_nowait())
    return found
