"""The process that workers are forked from, which has imported what they need, once for all.

It is started clean (by spawn, without OpenGL and without threads of ours) and answers requests on
a socket. A worker that is forked from it starts in milliseconds and shares the imports' memory.
Workers end with their server, and the server with the process that started it.
"""

from __future__ import annotations

import atexit
import gc
import importlib
import multiprocessing
import os
import pickle
import signal
import socket
import sys
import threading
import time
import warnings
from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import Any

from pjpdaf import entry
from pjpdaf.errors import InfrastructureError

REPLY_LIMIT_S = 300.0  # for the server to start and to import
END_LIMIT_S = 5.0  # for a process to end by itself
POLL_S = 0.005
MESSAGE_BYTES = 1 << 17
# Ctrl-C and a closed terminal reach the whole process group: only the parent decides about them.
TERMINAL_SIGNALS = (signal.SIGINT, signal.SIGHUP)
# Variables read after the fork, by OpenGL or by us. Where another one changes a new server is
# started: the interpreter and the libraries read theirs when they are loaded.
READ_LATE = (
    *("PJPDAF_BENCH", "XDG_", "PYTEST_", "MUJOCO_", "PYOPENGL_", "DISPLAY", "WAYLAND_DISPLAY"),
    *("LP_", "MESA_", "GALLIUM_", "LIBGL_", "EGL_", "__EGL_", "__GLX_"),
)
_server: WorkerServer | None = None
_starting = threading.Lock()


@dataclass(frozen=True)
class Surroundings:
    """What a worker takes over from the process that asks for it, as a spawned one would.

    variables: of READ_LATE; folder: the current one, None where it was removed.
    """

    variables: Mapping[str, str]
    folder: Path | None
    path: tuple[str, ...]

    @staticmethod
    def here() -> Surroundings:
        """Those of this process."""
        late = {name: v for name, v in os.environ.items() if name.startswith(READ_LATE)}
        try:
            folder = Path.cwd()
        except OSError:
            folder = None
        return Surroundings(late, folder, tuple(sys.path))

    def enter(self) -> None:
        """Make them this process's own."""
        for name in [name for name in os.environ if name.startswith(READ_LATE)]:
            del os.environ[name]
        os.environ.update(self.variables)
        if self.folder is not None:
            with suppress(OSError):
                os.chdir(self.folder)
        sys.path[:] = self.path
        importlib.invalidate_caches()


class WorkerProcess:
    """A forked worker, as seen from the process that asked for it."""

    def __init__(self, server: WorkerServer, number: int, pid: int) -> None:
        self._server, self._number, self.pid = server, number, pid
        self._code: int | None = None

    @property
    def exit_code(self) -> int | None:
        """None while it lives; the negative signal where one killed it."""
        if self._code is None:
            try:
                self._code = self._server.ask("poll", self._number)
            except OSError:  # the server was killed, and its workers end with it
                with suppress(ProcessLookupError):
                    os.kill(self.pid, signal.SIGKILL)
                self._code = -signal.SIGKILL
        return self._code

    def kill(self) -> None:
        """Kill it, if it lives."""
        with suppress(OSError):
            self._server.ask("kill", self._number)

    def join(self, limit_s: float | None = None) -> None:
        """Wait for its end."""
        end = None if limit_s is None else time.monotonic() + limit_s
        while self.exit_code is None and (end is None or time.monotonic() < end):
            time.sleep(POLL_S)


class WorkerServer:
    """This process's end of the socket to its server."""

    def __init__(self) -> None:
        self._owner, self._early = os.getpid(), _read_early(os.environ)
        self._lock, self._asked, self._gone = threading.Lock(), 0, False
        self._socket, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self._socket.settimeout(REPLY_LIMIT_S)
        # Spawn: a child forked beside a GL context hangs, and this process may have one.
        spawn = multiprocessing.get_context("spawn")
        self._process = spawn.Process(target=entry.serve_forks, args=(theirs,))
        with terminal_signals_blocked(), theirs:
            self._process.start()

    @property
    def fits(self) -> bool:
        """Whether it lives, and a worker from it is as one that is started here and now."""
        here = self._owner == os.getpid() and self._early == _read_early(os.environ)
        return here and not self._gone and self._process.is_alive()

    def fork(self, pipe: Connection, modules: Collection[str]) -> WorkerProcess:
        """A new worker that answers the tasks of a pipe. modules: imported first, in the server.

        Raises OSError where the server has ended, InfrastructureError where it does not answer.
        """
        given = Surroundings.here(), tuple(modules)
        number, pid = self.ask("fork", *given, handle=pipe.fileno())
        return WorkerProcess(self, number, pid)

    def ask(self, request: str, *arguments: Any, handle: int | None = None) -> Any:
        """The server's answer to a request. Raises as `fork`, and what the request raises."""
        with self._lock:
            self._asked += 1
            message = pickle.dumps((self._asked, request, arguments))
            try:
                socket.send_fds(self._socket, [message], [] if handle is None else [handle])
                while True:
                    answer = self._socket.recv(MESSAGE_BYTES)
                    if not answer:
                        raise ConnectionResetError("the server of the workers has ended")
                    number, kind, value = pickle.loads(answer)
                    if number == self._asked:  # else of a request that Ctrl-C interrupted
                        break
            except TimeoutError:
                raise InfrastructureError(
                    f"worker processes do not start within {REPLY_LIMIT_S:.0f} s"
                ) from None
            except OSError:
                self._gone = True  # before the system says so: its socket closes first
                raise
        if kind == "raised":
            raise value
        return value

    def close(self) -> None:
        """End it and its workers."""
        self._socket.close()
        if self._owner != os.getpid():
            return
        self._process.join(END_LIMIT_S)
        if self._process.exitcode is None:
            self._process.kill()
            self._process.join()
        self._process.close()


def fork_worker(pipe: Connection, modules: Collection[str] = ()) -> WorkerProcess:
    """A new worker of this process's server, which is started where it has none that fits.

    pipe: the worker's end, which the caller closes. modules: of ours, imported before the fork.
    """
    ours = {name for name in modules if name.partition(".")[0] in entry.PACKAGES}
    try:
        return _server_here().fork(pipe, ours)
    except OSError:  # it was killed just now
        return _server_here().fork(pipe, ours)


def _server_here() -> WorkerServer:
    global _server
    with _starting:
        if _server is None or not _server.fits:
            if _server is None:
                atexit.register(_close_server)
            else:
                _server.close()
            _server = WorkerServer()
        return _server


def _close_server() -> None:
    if _server is not None:
        _server.close()


def _read_early(environment: Mapping[str, str]) -> dict[str, str]:
    return {k: v for k, v in environment.items() if not k.startswith(READ_LATE)}


@contextmanager
def terminal_signals_blocked() -> Iterator[None]:
    """Block `TERMINAL_SIGNALS`, also in the processes that are started in the block.

    Another thread may be sent the signal all the same, and Python calls the handler in the main
    thread: handlers wait for the end of the block, so that no process is left half started.
    """
    before = signal.pthread_sigmask(signal.SIG_BLOCK, TERMINAL_SIGNALS)
    try:
        with _handlers_waiting():
            yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def _handlers_waiting() -> Iterator[None]:
    """Call Python's handlers of signals that end a command at the end of the block."""
    arrived: list[int] = []
    handlers = {}
    if threading.current_thread() is threading.main_thread():
        handlers = {
            number: signal.getsignal(number) for number in (*TERMINAL_SIGNALS, signal.SIGTERM)
        }
    handlers = {number: handler for number, handler in handlers.items() if callable(handler)}
    for number in handlers:
        signal.signal(number, lambda n, _: arrived.append(n))
    try:
        yield
    finally:
        for number, handler in handlers.items():
            signal.signal(number, handler)
        for late in arrived:
            signal.raise_signal(late)


class _Forks:
    """In the server: its workers by number, and the requests, each a method.

    channel: the server's end of the socket.
    """

    def __init__(self, channel: socket.socket) -> None:
        self._channel = channel
        self._codes: dict[int, int] = {}
        self._context = multiprocessing.get_context("fork")
        self._workers: dict[int, BaseProcess] = {}
        self._numbers = 0

    def fork(
        self, surroundings: Surroundings, modules: tuple[str, ...], handle: int
    ) -> tuple[int, int]:
        """Number and process id of a new worker."""
        new = [name for name in modules if name not in sys.modules]
        if new:
            gc.disable()  # an import makes no garbage, and looking for it takes a tenth of the time
            try:
                for name in new:
                    importlib.import_module(name)
            finally:
                gc.enable()
            # What is here for good: no worker's collector touches, and so copies, its memory.
            gc.collect()
            gc.freeze()
        worker = self._context.Process(target=self._work, args=(surroundings, handle))
        with warnings.catch_warnings():
            # Of threads of libraries that take care of a fork themselves (OpenBLAS, jemalloc).
            warnings.simplefilter("ignore", DeprecationWarning)
            worker.start()
        self._numbers += 1
        self._workers[self._numbers] = worker
        assert worker.pid is not None
        return self._numbers, worker.pid

    def poll(self, number: int) -> int | None:
        """Exit code of a worker, None while it lives."""
        if number not in self._codes:
            code = self._workers[number].exitcode
            if code is None:
                return None
            self._codes[number] = code
            self._workers.pop(number).close()
        return self._codes[number]

    def kill(self, number: int) -> None:
        """Kill a worker, if it lives."""
        if number in self._workers:
            self._workers[number].kill()

    def kill_all(self) -> None:
        """Kill all workers."""
        for worker in self._workers.values():
            worker.kill()

    def _work(self, surroundings: Surroundings, handle: int) -> None:
        """In a forked worker: answer the tasks of the pipe with this handle."""
        self._channel.close()  # its end says that the server has ended
        surroundings.enter()
        if "numpy.random" in sys.modules:  # else all workers draw the same from numpy's generator
            sys.modules["numpy.random"].seed()
        importlib.import_module("sim.processes").serve(Connection(handle))


def serve_forks(channel: socket.socket) -> None:
    """In the server: answer requests, until the other end of the socket is closed."""
    for number in TERMINAL_SIGNALS:
        signal.signal(number, signal.SIG_IGN)
    forks = _Forks(channel)
    try:
        while True:
            message, handles, _, _ = socket.recv_fds(channel, MESSAGE_BYTES, 1)
            if not message:
                return
            number, request, arguments = pickle.loads(message)
            try:
                answer = number, "returned", getattr(forks, request)(*arguments, *handles)
            except Exception as fault:
                answer = number, "raised", RuntimeError(f"{type(fault).__name__}: {fault}")
            for handle in handles:
                os.close(handle)
            channel.send(pickle.dumps(answer))
    except OSError:  # the other end was killed
        return
    finally:
        forks.kill_all()
