"""Whole runs: real pictures, real workers, real files."""

import fcntl
import hashlib
import os
import signal
import subprocess
import termios
from dataclasses import replace

import pytest
from commands import (
    ENVIRONMENT,
    LIMIT_S,
    assert_one_line,
    command,
    in_this_process,
    pending,
    started,
    wait_until,
)
from made_dataset import contents, made_dataset

from pjpdaf.errors import BenchError
from reports.run.load import load
from reports.run.rows import rows_of
from reports.run.save import RunInfo, save
from reports.score.records import EpisodeFailure
from scenarios.execute.episodes import EPISODE_TIME_LIMIT_S, play_all
from scenarios.play.job import Job, System
from scenarios.play.plan import PlanRequest, plan
from scenarios.play.play import play_complete
from scenarios.run.save_run import save_run
from scenarios.spec.names import load_scenario
from sim.processes import ATTEMPTS

QUICK = ("--set", "frames=2", "--set", "background_frames=2")
QUICK += ("--set", "detector.background_learn_min=2")
TABLES = ("frames.parquet", "episodes.parquet", "events.parquet")


def bench(*words, **options):
    words = command(*words)
    return subprocess.run(
        words, env=ENVIRONMENT, capture_output=True, text=True, check=False, **options
    )


def hashes(run):
    files = [*TABLES, *sorted(p.relative_to(run) for p in run.rglob("*.jpg"))]
    return {str(f): hashlib.sha256((run / f).read_bytes()).hexdigest() for f in files}


def job(seed=0, system=None, frames=2, size_px=(96, 72), **overrides):
    values = {"frames": frames, **overrides}
    return Job(load_scenario("calm_table"), seed, values, system or System(), size_px=size_px)


@pytest.mark.long
def test_same_bytes_for_one_and_two_jobs_from_any_folder(tmp_path, monkeypatch):
    # In one job the worker plays the second after the first, in two jobs each has its own.
    words = ("run", "cross", "bounce", "--seeds", "1", *QUICK, "--jobs")
    done = bench(*words, 1, "--out", "run1", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    monkeypatch.chdir(tmp_path / "run1")
    done = in_this_process(*words, 2, "--out", tmp_path / "run2")
    assert done.returncode == 0, done.stderr
    runs = [tmp_path / "run1", tmp_path / "run2"]
    first, second = map(hashes, runs)
    assert first == second
    assert len(first) > len(TABLES)
    saved = load(runs[0])
    assert len(saved.frames) == 2 * 2 * 3
    assert (runs[0] / "report.html").stat().st_size > 100_000


@pytest.mark.long
def test_calm_table_is_tracked(tmp_path):
    # Half the scenario's resolution: an eighth of the time.
    played = rows_of(play_complete(job(frames=12, size_px=(320, 240))))
    saved = load(save(tmp_path / "r", [played], RunInfo("r")))
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
    def __init__(self, cameras):
        self.inner = PJPDAF(cameras)
        PLAYED.append(self)
    def start(self, seen):
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


@pytest.fixture
def footage(tmp_path_factory):
    """Four kept episodes: an interrupted run is the same with a renderer, but takes longer."""
    return made_dataset(tmp_path_factory)


def waiting_run(folder, footage, **options):
    """`run` in its third episode, on one worker."""
    (folder / "waiting_plug_in.py").write_text(WAITING)
    words = ("run", "--from", footage, "--set", "detector.background_learn_min=2", "--jobs", "1")
    words += ("--tracker", "waiting_plug_in:Waits", "--out", "r")
    process = started(*words, cwd=folder, **options)
    wait_until((folder / "third").exists, process)
    return process


def assert_two_episodes_are_saved(run):
    saved = load(run)
    assert not saved.meta["complete"]
    assert len(saved.episodes) // 3 == 2


@pytest.mark.long
@pytest.mark.parametrize(
    ("number", "second"),
    [
        (signal.SIGINT, signal.SIGTERM),
        (signal.SIGTERM, None),
        (signal.SIGHUP, signal.SIGINT),
    ],
)
def test_an_interrupted_run_keeps_what_is_finished(tmp_path, footage, number, second):
    process = waiting_run(tmp_path, footage)
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
    assert "interrupted: 2 of 4 episodes are in the saved run" in said
    command = "pjpdaf-bench run --resume r --tracker waiting_plug_in:Waits"
    assert f"`{command}` goes on" in said
    assert (tmp_path / "r.part" / "request.json").is_file()
    assert (tmp_path / "r" / "report.html").is_file()


@pytest.mark.long
def test_a_run_in_a_terminal_that_is_closed_keeps_what_is_finished(tmp_path, footage):
    ours, theirs = os.openpty()
    (tmp_path / "go").touch()
    # Its controlling terminal: what hangs up when our end of it is closed.
    process = waiting_run(
        tmp_path,
        footage,
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


def test_a_killed_run_goes_on_and_ends_as_if_undisturbed(tmp_path, monkeypatch, footage, executor):
    setting = "detector.background_learn_min=2"
    words = ("run", "--from", footage, "--set", setting, "--jobs", "1", "--films", "--out", "r")
    process = started(*words, cwd=tmp_path)
    journal = tmp_path / "r.part" / "journal.bin"
    wait_until(lambda: journal.exists() and journal.stat().st_size > 5000, process)
    process.kill()
    process.communicate(timeout=LIMIT_S)
    assert not (tmp_path / "r").exists()

    monkeypatch.chdir(tmp_path)
    done = in_this_process("run", "--resume", "r", "--jobs", "1")
    assert done.returncode == 0, done.stderr
    assert "were there" in done.stdout
    assert [path.name for path in tmp_path.iterdir()] == ["r"]

    request = PlanRequest(settings=(setting,), keep_pictures=True, keep_films=True, dataset=footage)
    jobs = plan(request)
    played = play_all(jobs, executor)
    undisturbed = save_run(request, jobs, played, tmp_path / "undisturbed" / "r").folder
    mine, theirs = contents(tmp_path / "r"), contents(undisturbed)
    assert mine.keys() - theirs.keys() == {"report.html"}
    assert [file for file in theirs if mine[file] != theirs[file]] == ["run.json"]
    metas = [load(run).meta for run in (tmp_path / "r", undisturbed)]
    differing = {key for key in metas[0] if metas[0][key] != metas[1][key]}
    assert differing <= {"timing", "provenance"}


def test_resume_takes_no_other_request(tmp_path):
    for words in (("cross",), ("--seeds", "2"), ("--set", "frames=2"), ("--no-cache",)):
        done = in_this_process("run", "--resume", tmp_path / "r", *words)
        assert_one_line(done, 2, "--resume goes on with what was asked for")
    done = in_this_process("run", "--resume", tmp_path / "r")
    assert_one_line(done, 2, "r.part: no such unfinished run")


class LimitedWhereItHangs:
    """Another executor's workers, one task after another; its limit is for `Hangs` alone."""

    def __init__(self, executor):
        self.executor = executor
        self.renderers, self.close = executor.renderers, executor.close

    def outcomes(self, function, tasks, limit_s, attempts=ATTEMPTS):
        for index, task in tasks.items():
            limit_s_here = limit_s if task.system == faulty("Hangs") else EPISODE_TIME_LIMIT_S
            yield from self.executor.outcomes(function, {index: task}, limit_s_here, attempts)


def faulty(name):
    return System(tracker=f"faulty_trackers:{name}")


@pytest.mark.long
def test_a_faulty_plug_in_fails_its_episode_and_the_rest_is_kept(executor):
    systems = (None, faulty("Raises"), faulty("Dies"), None)
    played = play_all([job(seed=k, system=one) for k, one in enumerate(systems)], executor)
    assert [bool(row.failure) for row in played.rows] == [False, True, True, False]
    assert "no step today" in played.rows[1].failure
    assert "its worker died 3 times (exit code 7)" in played.rows[2].failure


def test_a_plug_in_that_hangs_fails_its_episode_and_the_rest_is_kept(executor):
    """The rest is played without the short limit, which a slow machine could exceed."""
    jobs = [job(), job(seed=1, system=faulty("Hangs")), job(seed=2)]
    played = play_all(jobs, LimitedWhereItHangs(executor), time_limit_s=2)
    assert [bool(row.failure) for row in played.rows] == [False, True, False]
    assert "not finished within 2 s" in played.rows[1].failure


def test_what_is_finished_is_not_played_unless_another_renderer_drew_it(executor):
    rows = [rows_of(EpisodeFailure("calm_table", seed, "kept")) for seed in range(2)]
    kept = {0: rows[0], 1: replace(rows[1], renderer="another")}
    told = []
    jobs = [job(), job(seed=1), job(seed=2)]
    played = play_all(jobs, executor, lambda index, row: told.append((index, row)), finished=kept)
    assert [row.failure for row in played.rows] == ["kept", "", ""]
    assert sorted(index for index, _ in told) == [1, 2]
    assert all(row is played.rows[index] for index, row in told)
    assert played.renderers == executor.renderers()


def test_a_fault_of_the_user_ends_the_run(executor):
    with pytest.raises(BenchError, match="outside its range"):
        play_all([job(speed="90")], executor)
