"""A real Dask scheduler and real worker processes on this machine, for tests that kill them."""

import os
import signal
import subprocess
import sys
import time
from contextlib import contextmanager, suppress
from pathlib import Path

from commands import server_pids, worker_pids

ROOT = Path(__file__).parents[1]
ENVIRONMENT = {
    **os.environ,
    "PYTHONPATH": os.pathsep.join([str(ROOT), str(ROOT / "tests")]),
    "LP_NUM_THREADS": "0",
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    # Innocent tasks live through hours of kills.
    "DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": "99",
}
START_LIMIT_S = 300.0


class DaskProcesses:
    """A scheduler, and nannies that each keep a worker of one thread alive."""

    def __init__(self, folder, **environment):
        self.folder, self.environment = folder, {**ENVIRONMENT, **environment}
        self.nannies = []
        self.scheduler = self._start("scheduler", "--host", "127.0.0.1", "--port", "0")
        self.address = self._address()

    def add_workers(self, count, **environment):
        """Start workers; returns their nannies."""
        words = (self.address, "--nthreads", "1", "--memory-limit", "0", "--no-dashboard")
        words = (*words, "--local-directory", str(self.folder / "space"))
        added = [self._start("worker", *words, **environment) for _ in range(count)]
        self.nannies += added
        return added

    def workers(self):
        """Process ids of the Dask workers."""
        return [pid for nanny in self.nannies for pid in self.workers_of(nanny)]

    def workers_of(self, nanny):
        """Process ids of the Dask workers of a nanny."""
        return server_pids(nanny.pid) if nanny.poll() is None else []

    def isolated(self):
        """Process ids of our isolated processes, children of the Dask workers."""
        return [pid for worker in self.workers() for pid in worker_pids(worker)]

    def cpu_s(self):
        """CPU seconds so far: of the scheduler, of living workers and what they started."""
        ticks = os.sysconf("SC_CLK_TCK")
        servers = [pid for worker in self.workers() for pid in server_pids(worker)]
        pids = [*self.workers(), *servers, *self.isolated()]
        return _ticks(self.scheduler.pid) / ticks, sum(map(_ticks, pids)) / ticks

    def close(self):
        """End everything at once."""
        pids = [*self.isolated(), *self.workers()]
        for process in (*self.nannies, self.scheduler):
            process.kill()
        for pid in pids:
            _kill(pid)
        for process in (*self.nannies, self.scheduler):
            process.wait()

    def _start(self, kind, *words, **environment):
        dashboard = ("--dashboard-address", "127.0.0.1:0") if kind == "scheduler" else ()
        command = [sys.executable, "-m", "dask", kind, *dashboard, *words]
        with (self.folder / f"{kind}.log").open("ab") as log:
            return subprocess.Popen(
                command,
                env={**self.environment, **environment},
                cwd=self.folder,
                stdout=log,
                stderr=subprocess.STDOUT,
                start_new_session=True,
            )

    def _address(self):
        due = time.monotonic() + START_LIMIT_S
        while time.monotonic() < due:
            for line in (self.folder / "scheduler.log").read_text().splitlines():
                if "Scheduler at:" in line:
                    return line.split()[-1]
            time.sleep(0.1)
        raise AssertionError((self.folder / "scheduler.log").read_text())


@contextmanager
def dask_processes(folder, workers, **environment):
    """A scheduler with this many workers, until the block ends."""
    processes = DaskProcesses(folder, **environment)
    try:
        processes.add_workers(workers)
        yield processes
    finally:
        processes.close()


def _ticks(pid):
    try:
        words = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return 0
    return sum(map(int, words[11:15]))  # user, system, and those of children that ended


def _kill(pid):
    with suppress(ProcessLookupError):
        os.kill(pid, signal.SIGKILL)
