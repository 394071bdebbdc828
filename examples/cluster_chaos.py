"""Small items through a Dask scheduler while its workers are killed: each answer arrives once.

python examples/cluster_chaos.py --items 100000 --kill-every 1000
"""

from __future__ import annotations

import argparse
import os
import random
import signal
import sys
import threading
import time
from collections import Counter
from contextlib import suppress
from pathlib import Path
from tempfile import TemporaryDirectory

sys.path.append(str(Path(__file__).parents[1] / "tests"))

from dask_cluster import DaskProcesses, dask_processes
from worker_tasks import double

from scenarios.execute.cluster import cluster_executor
from scenarios.execute.place import Place
from scenarios.execute.software import PlugIns
from sim.processes import Answer

POLL_S = 0.05


class Killer(threading.Thread):
    """Kills a Dask worker, one of our isolated processes, or a nanny with its worker.

    every: mean number of answers between two kills; answered: as many as there are by now.
    """

    def __init__(self, processes: DaskProcesses, every: float, seed: int) -> None:
        super().__init__(daemon=True)
        self._processes, self._every, self._rng = processes, every, random.Random(seed)
        self.answered, self.over, self.kills = 0, threading.Event(), Counter[str]()

    def run(self) -> None:
        due = self._rng.expovariate(1 / self._every)
        while not self.over.wait(POLL_S):
            self._replace_ended()
            if self.answered < due:
                continue
            due = self.answered + self._rng.expovariate(1 / self._every)
            kind = self._rng.choice(["worker", "isolated process", "nanny and worker"])
            if kind == "nanny and worker":
                nanny = self._rng.choice(self._processes.nannies)
                workers = self._processes.workers_of(nanny)
                nanny.kill()
                self._kill(workers)
            else:
                victims = (
                    self._processes.workers() if kind == "worker" else self._processes.isolated()
                )
                if not victims:
                    continue
                self._kill([self._rng.choice(victims)])
            self.kills[kind] += 1

    def _replace_ended(self) -> None:
        """Start nannies in place of those that were killed, or gave up on a slow machine."""
        for nanny in [one for one in self._processes.nannies if one.poll() is not None]:
            self._processes.nannies.remove(nanny)
            self._processes.add_workers(1)

    @staticmethod
    def _kill(pids: list[int]) -> None:
        for pid in pids:
            with suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--items", type=int, default=100_000)
    parser.add_argument("--workers", type=int, default=4)
    parser.add_argument("--kill-every", type=float, default=0.0, help="Mean answers; 0: never.")
    parser.add_argument("--seed", type=int, default=1)
    wanted = parser.parse_args()
    with (
        TemporaryDirectory() as name,
        dask_processes(Path(name), wanted.workers) as processes,
        cluster_executor(Place(0, processes.address), PlugIns()) as executor,
    ):
        killer = Killer(processes, wanted.kill_every or 1.0, wanted.seed)
        before = processes.cpu_s()
        started, here = time.monotonic(), time.process_time()
        if wanted.kill_every:
            killer.start()
        arrived = Counter[int]()
        for pair in executor.outcomes(double, {n: n for n in range(wanted.items)}, 60.0, 99):
            if pair is not None:
                assert pair[1] == Answer(2 * pair[0]), pair
                arrived[pair[0]] += 1
                killer.answered += 1
                if killer.answered % 10_000 == 0:
                    print(f"{killer.answered} answers, {killer.kills.total()} kills", flush=True)
        wall_s, here_s = time.monotonic() - started, time.process_time() - here
        killer.over.set()
        after = processes.cpu_s()
    assert sorted(arrived) == list(range(wanted.items))
    assert set(arrived.values()) == {1}
    print(f"{wanted.items} items, each answer once, {wanted.workers} workers, {wall_s:.0f} s")
    print("kills: " + (", ".join(f"{n} x {k}" for k, n in killer.kills.items()) or "none"))
    scheduler_s, workers_s = (b - a for a, b in zip(before, after, strict=True))
    each = 1e3 / wanted.items
    print(f"CPU an item: client {here_s * each:.2f} ms, scheduler {scheduler_s * each:.2f} ms")
    if not wanted.kill_every:  # else what the dead have used is not known
        print(f"CPU an item: workers {workers_s * each:.2f} ms")


if __name__ == "__main__":
    main()
