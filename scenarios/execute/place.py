"""Where tasks are executed: processes of this machine, or a cluster."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from pjpdaf.errors import BenchError, InfrastructureError
from reports.summary.text import count
from scenarios.execute.executor import Executor
from scenarios.execute.local import local_executor, worker_count
from scenarios.execute.software import PlugIns

LOCAL = "local:"
EXTRA = "pip install 'pjpdaf-bench[cluster]'"
_ADDRESS = re.compile(r"(tcp|tls|ws|wss|ucx|ucxx)://[^\s/]+:\d{1,5}")


@dataclass(frozen=True)
class Place:
    """Where tasks are executed.

    workers: processes that are started here, 0 for none; scheduler: address of Dask's scheduler, ""
    for none, `local` for one that is started here.
    """

    workers: int
    scheduler: str = ""

    def __str__(self) -> str:
        if not self.scheduler:
            return count(self.workers, "worker")
        if self.scheduler == "local":
            return f"a cluster of {count(self.workers, 'worker')} here"
        return f"the cluster {self.scheduler}"


def place_of(jobs: int | None, cluster: str | None) -> Place:
    """The place of `--jobs` and `--cluster`. Raises BenchError."""
    if cluster is None:
        return Place(worker_count(jobs))
    if jobs is not None:
        raise BenchError("--jobs is for processes of this machine: leave it out with --cluster")
    if cluster.startswith(LOCAL):
        number = cluster.removeprefix(LOCAL)
        if not number.isdecimal():
            raise BenchError(f"--cluster {cluster[:60]}: must be local:N, as local:4")
        try:
            return Place(worker_count(int(number)), "local")
        except BenchError as fault:
            raise BenchError(str(fault).replace("--jobs", "--cluster local:N")) from None
    if not _ADDRESS.fullmatch(cluster):
        raise BenchError(
            f"--cluster {cluster[:60]}: must be the address of a Dask scheduler, as "
            "tcp://host:8786, or local:N"
        )
    return Place(0, cluster)


@contextmanager
def executor_at(
    place: Place, plug_ins: PlugIns | None = None, tasks_per_worker: int = 0
) -> Iterator[Executor]:
    """An executor at a place, until the block ends.

    plug_ins: those of the tasks, which a cluster must have; tasks_per_worker: as of
    `sim.processes.WorkerPool`. Raises InfrastructureError where a cluster cannot be used.
    """
    if not place.scheduler:
        with local_executor(place.workers, tasks_per_worker) as executor:
            yield executor
        return
    try:  # here: Dask is an extra, and takes a second to import
        from scenarios.execute.cluster import cluster_executor
    except ImportError as fault:
        raise InfrastructureError(f"--cluster needs Dask ({fault})", EXTRA) from None
    with cluster_executor(place, plug_ins or PlugIns(), tasks_per_worker) as executor:
        yield executor
