"""A client of Dask that waits for nothing without an end, and a cluster on this machine."""

from __future__ import annotations

import logging
import os
import queue
import signal
import threading
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Any, TypeVar

import distributed
from distributed.versions import VersionMismatchWarning

from pjpdaf.errors import InfrastructureError
from pjpdaf.printable import printable
from sim.processes import WORKER_ENVIRONMENT
from sim.worker_server import TERMINAL_SIGNALS

CONNECT_S = 15.0
END_S = 10.0  # for workers to hear of an end
R = TypeVar("R")


def within(limit_s: float, function: Callable[[], R]) -> R:
    """The value of a call that Dask would wait for without an end.

    Raises TimeoutError, then it goes on in its thread; and what the function raises.
    """
    answers: queue.SimpleQueue[Any] = queue.SimpleQueue()

    def call() -> None:
        try:
            answers.put((function(), None))
        except Exception as fault:
            answers.put((None, fault))

    threading.Thread(target=call, daemon=True).start()
    try:
        value, fault = answers.get(timeout=limit_s)
    except queue.Empty:
        raise TimeoutError from None
    if fault is not None:
        raise fault
    answer: R = value
    return answer


@contextmanager
def client_of(address: Any) -> Iterator[Any]:
    """A client of a scheduler. Raises InfrastructureError where none answers."""
    try:
        with warnings.catch_warnings():
            # We compare versions ourselves, and refuse.
            warnings.simplefilter("ignore", VersionMismatchWarning)
            client = distributed.Client(address, timeout=CONNECT_S, set_as_default=False)
    except Exception as fault:  # of sockets, TLS, another program's answer
        reason = printable(str(fault)) or type(fault).__name__
        raise InfrastructureError(f"no Dask scheduler answers at {address}: {reason}") from None
    try:
        yield client
    finally:
        with suppress(Exception):
            within(END_S, lambda: client.close(timeout=END_S))


@contextmanager
def local_cluster(workers: int) -> Iterator[Any]:
    """A scheduler in this process and worker processes of one thread each."""
    for name, value in WORKER_ENVIRONMENT.items():
        os.environ.setdefault(name, value)
    # Inherited by Dask's threads, and by the processes that these start: see `sim.processes`.
    before = signal.pthread_sigmask(signal.SIG_BLOCK, TERMINAL_SIGNALS)
    try:
        cluster = distributed.LocalCluster(
            n_workers=workers,
            threads_per_worker=1,
            processes=True,
            memory_limit=0,  # the Dask worker is small; our isolated processes are none of its
            dashboard_address="127.0.0.1:0",
            silence_logs=logging.CRITICAL,
        )
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
    try:
        yield cluster
    finally:
        with suppress(Exception):
            within(2 * END_S, lambda: cluster.close(timeout=END_S))


@contextmanager
def silent_loggers() -> Iterator[None]:
    """Keep Dask's own lines from standard error: each of its faults becomes one of ours."""
    before = logging.root.manager.disable
    logging.disable(logging.CRITICAL)  # ours are none
    try:
        yield
    finally:
        logging.disable(before)
