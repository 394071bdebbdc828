"""Whole runs: real pictures, real workers, real files."""

import hashlib
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from pjpdaf.errors import BenchError
from reports.run.load import load
from scenarios.execute.episodes import play_all
from scenarios.play.play import Job, System
from scenarios.spec.names import load_scenario

ROOT = Path(__file__).parents[3]
TABLES = ("frames.parquet", "episodes.parquet", "events.parquet")


def bench(*words, **kwargs):
    env = {**os.environ, "PYTHONPATH": str(ROOT)}
    command = [sys.executable, "-m", "scenarios", *map(str, words)]
    return subprocess.run(command, env=env, capture_output=True, text=True, check=False, **kwargs)


def hashes(run):
    files = [*TABLES, *sorted(p.relative_to(run) for p in run.rglob("*.jpg"))]
    return {str(f): hashlib.sha256((run / f).read_bytes()).hexdigest() for f in files}


def job(name="calm_table", seed=0, system=None, frames=4, **overrides):
    values = {"frames": frames, **overrides}
    return Job(load_scenario(name), seed, values, system or System())


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


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupted_run_keeps_what_is_finished(tmp_path, number):
    command = [sys.executable, "-m", "scenarios", "run", "calm_table", "--seeds", "40"]
    command += ["--set", "frames=3", "--jobs", "2", "--out", str(tmp_path / "r")]
    env = {**os.environ, "PYTHONPATH": str(ROOT)}
    process = subprocess.Popen(
        command, env=env, stderr=subprocess.PIPE, text=True, start_new_session=True
    )
    time.sleep(12)
    if number == signal.SIGINT:
        os.killpg(process.pid, number)  # Ctrl-C reaches all processes of a terminal
    else:
        process.send_signal(number)
    _, said = process.communicate(timeout=60)
    assert "Traceback" not in said
    assert process.returncode == 130, said
    saved = load(tmp_path / "r")
    assert not saved.meta["complete"]
    assert 0 < len(saved.episodes) // 3 < 40
    assert f"{len(saved.episodes) // 3} of 40" in said


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
        ("Hangs", "not finished within 12 s"),
    ],
)
def test_a_faulty_plug_in_fails_its_episode_and_the_rest_is_kept(
    tmp_path, monkeypatch, factory, reason
):
    (tmp_path / "faulty_plug_ins.py").write_text(PLUG_INS)
    monkeypatch.syspath_prepend(tmp_path)  # workers take over the parent's path
    faulty = System(tracker=f"faulty_plug_ins:{factory}")
    played = play_all([job(), job(seed=1, system=faulty), job(seed=2)], 2, time_limit_s=12)
    assert [bool(row.failure) for row in played.rows] == [False, True, False]
    assert reason in played.rows[1].failure


def test_a_fault_of_the_user_ends_the_run(tmp_path):
    with pytest.raises(BenchError, match="outside its range"):
        play_all([job(speed="90")], 1)
