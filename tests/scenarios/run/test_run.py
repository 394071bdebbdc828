"""Whole runs: real pictures, real workers, real files."""

import fcntl
import hashlib
import os
import signal
import subprocess
import termios

import pytest
from commands import ENVIRONMENT, LIMIT_S, command, pending, started, wait_until

from pjpdaf.errors import BenchError
from reports.run.load import load
from scenarios.execute.episodes import EPISODE_TIME_LIMIT_S, play_all
from scenarios.execute.local import local_executor
from scenarios.play.job import Job, System
from scenarios.spec.names import load_scenario

TABLES = ("frames.parquet", "episodes.parquet", "events.parquet")


def bench(*words, **options):
    words = command(*words)
    return subprocess.run(
        words, env=ENVIRONMENT, capture_output=True, text=True, check=False, **options
    )


def hashes(run):
    files = [*TABLES, *sorted(p.relative_to(run) for p in run.rglob("*.jpg"))]
    return {str(f): hashlib.sha256((run / f).read_bytes()).hexdigest() for f in files}


def job(name="calm_table", seed=0, system=None, frames=2, **overrides):
    """An episode of small pictures: far from its time limit on a slow machine too."""
    values = {"frames": frames, **overrides}
    return Job(load_scenario(name), seed, values, system or System(), size_px=(96, 72))


def test_same_bytes_for_one_and_four_jobs_from_any_folder(tmp_path):
    runs = []
    for jobs in (1, 4):
        words = ("run", "cross", "bounce", "--seeds", "2", "--set", "frames=6", "--jobs", jobs)
        done = bench(*words, "--out", f"run{jobs}", cwd=tmp_path)
        assert done.returncode == 0, done.stderr
        runs.append(tmp_path / f"run{jobs}")
    first, second = map(hashes, runs)
    assert first == second
    assert len(first) > len(TABLES)
    saved = load(runs[0])
    assert len(saved.frames) == 2 * 2 * 6 * 3
    assert (runs[0] / "report.html").stat().st_size > 100_000


def test_calm_table_is_tracked(tmp_path):
    done = bench(
        "run", "calm_table", "--seeds", "1", "--set", "frames=40", "--out", "r", cwd=tmp_path
    )
    assert done.returncode == 0, done.stderr
    saved = load(tmp_path / "r")
    errors = saved.frames["error_mm"].dropna()
    # Most of the error is the distance from a body's centre to its visible surface: 15 to 35 mm.
    assert errors.median() < 40
    assert (saved.frames["error_mm"] < 100).mean() > 0.95
    assert saved.events.empty


# A tracker whose third episode does not end, in a command whose saving waits until GO is there.
WAITING = """
import multiprocessing, sys, time
from pathlib import Path
from pjpdaf.tracker.filter import PJPDAF

HERE = Path(__file__).parent
PLAYED = []

def wait_for(name):
    while not (HERE / name).exists():
        time.sleep(0.01)

def hook(event, arguments):
    if event == "os.mkdir" and ".r.part-" in str(arguments[0]):
        (HERE / "saving").touch()
        wait_for("go")

class Waits:
    def __init__(self, cameras): self.inner = PJPDAF(cameras)
    def start(self, seen):
        PLAYED.append(1)
        if len(PLAYED) == 3:
            (HERE / "third").touch()
            wait_for("never")
        return self.inner.start(seen)
    def step(self, state, seen, dt_s): return self.inner.step(state, seen, dt_s)
    def estimates(self, state): return self.inner.estimates(state)
    def predict(self, state, dt_s): return self.inner.predict(state, dt_s)

if multiprocessing.parent_process() is None:
    sys.addaudithook(hook)
"""


def waiting_run(folder, **options):
    """`run` in its third episode, on one worker."""
    (folder / "waiting_plug_in.py").write_text(WAITING)
    words = ("run", "calm_table", "--seeds", "40", "--set", "frames=2", "--jobs", "1")
    words += ("--tracker", "waiting_plug_in:Waits", "--out", "r")
    process = started(*words, cwd=folder, **options)
    wait_until((folder / "third").exists, process)
    return process


def assert_two_episodes_are_saved(run):
    saved = load(run)
    assert not saved.meta["complete"]
    assert len(saved.episodes) // 3 == 2


@pytest.mark.parametrize(
    ("number", "second"),
    [(signal.SIGINT, signal.SIGTERM), (signal.SIGTERM, None), (signal.SIGHUP, signal.SIGINT)],
)
def test_an_interrupted_run_keeps_what_is_finished(tmp_path, number, second):
    process = waiting_run(tmp_path)
    if number == signal.SIGTERM:
        process.send_signal(number)
    else:
        os.killpg(process.pid, number)  # of a terminal; reaches all its processes
    wait_until((tmp_path / "saving").exists, process)
    if second is not None:
        process.send_signal(second)
        wait_until(lambda: not pending(process.pid), process)
    (tmp_path / "go").touch()
    _, said = process.communicate(timeout=LIMIT_S)
    assert "Traceback" not in said
    assert process.returncode == 130, said
    assert_two_episodes_are_saved(tmp_path / "r")
    assert "interrupted: 2 of 40 episodes are in the saved run" in said
    assert (tmp_path / "r" / "report.html").is_file()


def test_a_run_in_a_terminal_that_is_closed_keeps_what_is_finished(tmp_path):
    ours, theirs = os.openpty()
    (tmp_path / "go").touch()
    # Its controlling terminal: what hangs up when our end of it is closed.
    process = waiting_run(
        tmp_path,
        stdin=theirs,
        stdout=theirs,
        stderr=theirs,
        preexec_fn=lambda: fcntl.ioctl(0, termios.TIOCSCTTY, 0),
    )
    os.close(theirs)
    os.close(ours)
    process.communicate(timeout=LIMIT_S)
    assert process.returncode == 130
    assert_two_episodes_are_saved(tmp_path / "r")
    assert (tmp_path / "r" / "report.html").is_file()


PLUG_INS = """
import os
from pjpdaf.tracker.filter import PJPDAF

class Broken:
    def __init__(self, cameras): self.inner = PJPDAF(cameras)
    def start(self, seen): return self.inner.start(seen)
    def estimates(self, state): return self.inner.estimates(state)
    def predict(self, state, dt_s): return self.inner.predict(state, dt_s)

class Raises(Broken):
    def step(self, state, seen, dt_s): raise RuntimeError("no step today")

class Dies(Broken):
    def step(self, state, seen, dt_s): os._exit(7)

class Hangs(Broken):
    def step(self, state, seen, dt_s):
        import time
        time.sleep(1000)
"""


@pytest.mark.parametrize(
    ("factory", "reason"),
    [
        ("Raises", "no step today"),
        ("Dies", "its worker died 3 times (exit code 7)"),
        ("Hangs", "not finished within 20 s"),
    ],
)
def test_a_faulty_plug_in_fails_its_episode_and_the_rest_is_kept(
    tmp_path, monkeypatch, factory, reason
):
    (tmp_path / "faulty_plug_ins.py").write_text(PLUG_INS)
    monkeypatch.syspath_prepend(tmp_path)  # workers take over the parent's path
    faulty = System(tracker=f"faulty_plug_ins:{factory}")
    jobs = [job(), job(seed=1, system=faulty), job(seed=2)]
    with local_executor(2) as executor:
        # The others take a third of a second: 20 s is enough on a machine that is 50 times slower.
        limit_s = 20 if factory == "Hangs" else EPISODE_TIME_LIMIT_S
        played = play_all(jobs, executor, time_limit_s=limit_s)
    assert [bool(row.failure) for row in played.rows] == [False, True, False]
    assert reason in played.rows[1].failure


def test_a_fault_of_the_user_ends_the_run(executor):
    with pytest.raises(BenchError, match="outside its range"):
        play_all([job(speed="90")], executor)
