"""What the start of a worker process costs: CPU time of a clean one, and of those forked from it.

python examples/worker_start.py
"""

from __future__ import annotations

import subprocess
import sys
import time
from pathlib import Path

from scenarios.execute.local import PLAYED_WITH, local_executor
from sim.processes import Answer

# As the server imports: `sim.worker_server`.
CLEAN = f"""
import gc, time
gc.disable()
import {", ".join(PLAYED_WITH)}
gc.enable()
gc.collect()
gc.freeze()
print(time.process_time())
"""
TRIES = 5


def used(_: int) -> tuple[float, float]:
    """CPU time [s] of this worker until now, and the memory [MB] that it shares with no other."""
    lines = Path("/proc/self/smaps_rollup").read_text().splitlines()
    private_kb = sum(int(line.split()[1]) for line in lines if line.startswith("Private"))
    return time.process_time(), private_kb / 1e3


def main() -> None:
    outputs = (
        subprocess.run([sys.executable, "-c", CLEAN], check=True, capture_output=True, text=True)
        for _ in range(TRIES)
    )
    clean_s = min(float(output.stdout) for output in outputs)
    forked = []
    for _ in range(TRIES):
        with local_executor(1) as executor:
            ended = next(done for done in executor.outcomes(used, {0: 0}, 60.0) if done is not None)
        assert isinstance(ended[1], Answer)
        forked.append(ended[1].value)
    forked_s, private_mb = min(forked)
    print(f"the server, once a command: {clean_s:.2f} s of CPU, mostly imports")
    print(
        f"a worker, forked from it: {1e3 * forked_s:.0f} ms of CPU, {private_mb:.0f} MB of its own"
    )


if __name__ == "__main__":
    main()
