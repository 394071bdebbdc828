"""Worker processes and their parent."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from commands import wait_until

from scenarios.execute.episodes import _play_safely
from scenarios.play.job import Job, System
from scenarios.spec.names import load_scenario

PARENT = """
import multiprocessing, time
from sim.processes import _prepare_worker

def work():
    _prepare_worker()
    print(multiprocessing.current_process().pid, flush=True)  # on standard error
    time.sleep(600)

if __name__ == "__main__":
    multiprocessing.get_context("spawn").Process(target=work).start()
"""


def runs(pid):
    try:
        # A zombie has ended; where nobody reaps orphans it stays in the table.
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


def test_worker_ends_with_a_killed_parent(tmp_path):
    program = tmp_path / "parent.py"
    program.write_text(PARENT)
    root = str(Path(__file__).parents[3])
    environment = {**os.environ, "PYTHONPATH": root}
    with subprocess.Popen(
        [sys.executable, str(program)], env=environment, stderr=subprocess.PIPE, text=True
    ) as parent:
        worker = int(parent.stderr.readline())
        assert runs(worker)
        parent.send_signal(signal.SIGKILL)
        wait_until(lambda: not runs(worker))


PLUG_INS = """
import sys
from pjpdaf.errors import BenchError
from pjpdaf.interfaces import Estimates
from own_tracker import NearestBlob

class Exits(NearestBlob):
    def step(self, state, seen, dt_s): sys.exit(3)

class Interrupts(NearestBlob):
    def step(self, state, seen, dt_s): raise KeyboardInterrupt

class Refuses(NearestBlob):
    def step(self, state, seen, dt_s): raise BenchError("of\\nmine")

class Odd(Exception):
    def __str__(self): raise ValueError

class RaisesOdd(NearestBlob):
    def step(self, state, seen, dt_s): raise Odd

class Alone(NearestBlob):
    def step(self, state, seen, dt_s): return self.estimates(state)

class Two(NearestBlob):
    def predict(self, state, dt_s):
        said = self.estimates(state)
        return Estimates(said.positions_m[:2], said.covariances_m2[:2], said.velocities_mps[:2],
                         said.status[:2])
"""


@pytest.mark.sample(3)
@pytest.mark.parametrize(
    ("factory", "reason"),
    [
        ("Exits", "step: raises SystemExit: 3 (garbage_plug_ins.py:8)"),
        ("Interrupts", "KeyboardInterrupt (garbage_plug_ins.py:11)"),
        ("Refuses", "step: raises BenchError: of mine (garbage_plug_ins.py:14)"),
        ("RaisesOdd", "step: raises Odd (garbage_plug_ins.py:20)"),
        ("Alone", "step: must return (state, Estimates), returns Estimates"),
        ("Two", "predict: must have 3 targets (head, right_hand, left_hand), has 2"),
    ],
)
def test_whatever_a_plug_in_does_ends_its_episode_alone(tmp_path, monkeypatch, factory, reason):
    (tmp_path / "garbage_plug_ins.py").write_text(PLUG_INS)
    monkeypatch.syspath_prepend(Path(__file__).parents[3] / "examples")
    monkeypatch.syspath_prepend(tmp_path)
    name = f"garbage_plug_ins:{factory}"
    monkeypatch.delitem(sys.modules, "garbage_plug_ins", raising=False)
    job = Job(
        load_scenario("calm_table"), 100, {"frames": 2}, System(tracker=name), size_px=(320, 240)
    )
    said = _play_safely(job).failure
    if factory != "Interrupts":  # in the parent that is Ctrl-C, so only a worker knows better
        reason = f"frame 1: tracker '{name}': {reason}"
    assert said == reason
