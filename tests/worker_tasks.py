"""Tasks of worker processes; their module loads nothing, so that a worker starts at once."""

import multiprocessing
import os
import signal
import sys
import time
from pathlib import Path


def double(x):
    return 2 * x


def prints_among_messages(x):
    return os.path.sameopenfile(sys.stdout.fileno(), sys.stderr.fileno())


def dies(x):
    if x == 1:
        os.kill(os.getpid(), signal.SIGKILL)
    return 2 * x


def dies_once(path):
    if not Path(path).exists():
        Path(path).touch()
        os._exit(3)
    return "again"


def hangs(x):
    time.sleep(1000 if x == 1 else 0)
    return x


def fails(x):
    if x == 1:
        raise KeyError("one")
    return x


def cannot_be_sent(x):
    return lambda: x


def pid(x):
    return os.getpid()


def slow_and_large(x):
    time.sleep(0.02)
    return bytes([x]) * 3_000_000


def starts_a_process(x):
    child = multiprocessing.get_context("spawn").Process(target=double, args=(1,))
    child.start()
    child.join()
    return child.exitcode


def answers(task):
    return task


class SlowToArrive:
    """A task that takes a second to be unpickled in the worker, as imports do."""

    def __reduce__(self):
        return time.sleep, (1.0,)


def counts_steps(wait_for):
    """Two steps, of which the parent hears while the task goes on, until the file is there."""
    from sim import processes
    from sim.steps import step

    processes.STEPS_S = 0.0
    step()
    step()
    while not Path(wait_for).exists():
        time.sleep(0.02)


def mixed(x):
    """One that ends its process, one that hangs, and many that answer."""
    if x == 2:
        time.sleep(1000)
    return dies(x)


def random_number(_):
    import numpy as np

    return float(np.random.rand())  # noqa: NPY002 - its own generator is the subject


def surroundings(name):
    """Current folder, first of the path and a variable; for "modules": the names of all modules."""
    if name == "modules":
        return sorted(sys.modules)
    return os.getcwd(), sys.path[0], os.environ.get(name)  # noqa: PTH109


def memory_with_holes(above_mb):
    """Megabytes of this process with 100 MB of holes, and after it has given memory back."""
    from sim.processes import give_back_memory

    blocks = [bytearray(1000) for _ in range(100_000)]
    kept = blocks[::1000]
    blocks.clear()
    before = resident_mb()
    give_back_memory(above_mb)
    assert len(kept) == 100
    return before, resident_mb()


def resident_mb():
    words = Path("/proc/self/status").read_text().split()
    return int(words[words.index("VmRSS:") + 1]) / 1e3


def memory_after(job):
    """Megabytes of this process after it has played a job: now, and at the most."""
    from scenarios.play.play import play_complete

    play_complete(job)
    words = Path("/proc/self/status").read_text().split()
    now, most = (int(words[words.index(name) + 1]) / 1e3 for name in ("VmRSS:", "VmHWM:"))
    return os.getpid(), now, most


def killed_while_it_writes(mark, often, write, sequence, labels, part):
    """Write a part of an export; that of seq_000001 only after so many attempts that are killed."""
    attempts = len(mark.read_text()) if mark.exists() else 0
    if sequence.name == "seq_000001" and attempts < often:
        mark.write_text("x" * (attempts + 1))
        (part / "half").mkdir()
        os.kill(os.getpid(), signal.SIGKILL)
    write(sequence, labels, part)
