"""A real scheduler and four real workers that are killed, hang, go, or have other software."""

import os
import random
import shutil
import signal
import subprocess
import threading
from contextlib import suppress
from pathlib import Path

import pytest
from commands import ENVIRONMENT, assert_one_line, bench, started, wait_until
from dask_cluster import dask_processes
from made_dataset import contents, made_dataset
from worker_tasks import dies, hangs, slow_and_large

from scenarios.execute.cluster import cluster_executor
from scenarios.execute.place import Place
from scenarios.execute.software import PlugIns
from sim.processes import ATTEMPTS, Answer, Lost

pytestmark = pytest.mark.long
ROOT = Path(__file__).parents[3]


@pytest.fixture(scope="module")
def dask(tmp_path_factory):
    with dask_processes(tmp_path_factory.mktemp("dask"), 4) as processes:
        yield processes


def outcomes(processes, function, tasks, limit_s=60.0, **options):
    with cluster_executor(Place(0, processes.address), PlugIns()) as executor:
        pairs = [p for p in executor.outcomes(function, tasks, limit_s, **options) if p]
    assert len(pairs) == len(dict(pairs))
    return dict(pairs)


def test_poisoned_and_hanging_tasks_are_lost_alone(dask):
    tasks = {n: n for n in range(40)}
    found = outcomes(dask, dies, tasks)
    assert found.pop(1) == Lost(late=False, attempts=ATTEMPTS, exit_code=-signal.SIGKILL)
    assert found == {n: Answer(2 * n) for n in tasks if n != 1}
    found = outcomes(dask, hangs, tasks, limit_s=3.0)
    assert found.pop(1).late
    assert found == {n: Answer(n) for n in tasks if n != 1}


def kills_its_dask_worker(x):
    """Takes the Dask worker with it, as where memory is short."""
    if x == 1:
        server = Path(f"/proc/{os.getppid()}/stat").read_text()
        os.kill(int(server.rpartition(")")[2].split()[1]), signal.SIGKILL)
        signal.pause()
    return 2 * x


def test_a_task_that_kills_every_worker_is_lost_alone(tmp_path):
    limited = {"DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": "2"}
    with dask_processes(tmp_path, 2, **limited) as processes:
        found = outcomes(processes, kills_its_dask_worker, {n: n for n in range(20)})
    assert found.pop(1) == Lost(late=False, attempts=3)
    assert found == {n: Answer(2 * n) for n in range(20) if n != 1}


def test_workers_killed_at_random_moments_lose_no_answer(dask, monkeypatch):
    monkeypatch.setenv("PJPDAF_BENCH_WORKER_WAIT_S", "600")  # on a busy machine they start slowly
    rng, over, kills = random.Random(2), threading.Event(), []

    def killer():
        while len(kills) < 12 and not over.wait(rng.uniform(0.5, 3.0)):
            pids = [*dask.workers(), *dask.isolated()]
            if pids:
                with suppress(ProcessLookupError):
                    os.kill(rng.choice(pids), signal.SIGKILL)
                    kills.append(1)

    thread = threading.Thread(target=killer)
    thread.start()
    try:
        found = outcomes(dask, slow_and_large, {n: n % 256 for n in range(400)}, 600.0, attempts=99)
    finally:
        over.set()
        thread.join()
    assert found == {n: Answer(bytes([n % 256]) * 3_000_000) for n in range(400)}
    assert kills


def words(tmp_path_factory):
    footage = made_dataset(tmp_path_factory)
    return ("run", "--from", footage, "--set", "detector.background_learn_min=2", "--films")


def tables(run):
    found = contents(run)
    return {name: found[name] for name in found if name not in ("run.json", "report.html")}


def test_a_run_and_a_data_set_of_a_cluster_are_those_of_this_machine(
    dask, tmp_path, tmp_path_factory
):
    run = words(tmp_path_factory)
    here = bench(*run, "--jobs", 1, "--out", tmp_path / "here")
    there = bench(*run, "--cluster", dask.address, "--out", tmp_path / "there")
    assert (here.returncode, there.returncode) == (0, 0), there.stderr
    assert tables(tmp_path / "here") == tables(tmp_path / "there")
    assert f"the cluster {dask.address}" in there.stdout.replace("\n", " ")
    make = ("dataset", "make", "cross", "recorded", "--seeds", "2", "--first-seed", "100")
    make = (*make, "--size", "96x72", "--set", "frames=4", "--set", "background_frames=2")
    make = (*make, "--labels", "depth,seg", "--export", "none")
    done = bench(*make, "--cluster", dask.address, "--out", tmp_path / "set")
    assert done.returncode == 0, done.stderr
    assert contents(tmp_path / "set") == contents(made_dataset(tmp_path_factory))


def test_a_scheduler_that_goes_is_one_line_and_the_command_goes_on(tmp_path, tmp_path_factory):
    run = (*words(tmp_path_factory), "--out", "r")
    with dask_processes(tmp_path, 1) as processes:
        process = started(*run, "--cluster", processes.address, cwd=tmp_path)
        journal = tmp_path / "r.part/journal.bin"
        wait_until(lambda: journal.exists() and journal.stat().st_size > 1000, process)
        processes.scheduler.kill()
        _, said = process.communicate(timeout=300)
    assert process.returncode == 5, said
    assert "has gone or does not answer" in said.splitlines()[-1]
    assert "episodes are kept; `pjpdaf-bench run --resume r` goes on" in said.splitlines()[-1]
    done = bench("run", "--resume", "r", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "were there" in done.stdout


def test_ctrl_c_keeps_what_is_finished(dask, tmp_path, tmp_path_factory):
    run = (*words(tmp_path_factory), "--out", "r")
    process = started(*run, "--cluster", dask.address, cwd=tmp_path)
    journal = tmp_path / "r.part/journal.bin"
    wait_until(lambda: journal.exists() and journal.stat().st_size > 1000, process)
    process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=300)
    assert process.returncode in (0, 130), said  # 0: it was at its end
    assert "Traceback" not in said


def test_a_worker_of_other_code_is_refused_in_one_line(tmp_path):
    other = tmp_path / "other"
    for name in ("pjpdaf", "sim", "reports", "scenarios"):
        shutil.copytree(ROOT / name, other / name, ignore=shutil.ignore_patterns("__pycache__"))
    changed = other / "sim/specs.py"
    changed.write_text(changed.read_text() + "# other\n")
    with dask_processes(tmp_path, 0) as processes:
        processes.add_workers(1, PYTHONPATH=str(other))
        line = ("run", "cross", "--seeds", "1", "--cluster", processes.address, "--out", "r")
        done = bench(*line, cwd=tmp_path, PJPDAF_BENCH_WORKER_WAIT_S="600")  # a slow start
    done.stderr = done.stderr.replace(f"waiting for workers of {processes.address}\n", "")
    fragments = ("worker tcp://127.0.0.1:", "other software", "the code of pjpdaf-bench", "here")
    assert_one_line(done, 2, *fragments)


def test_without_dask_it_is_one_line(tmp_path):
    (tmp_path / "distributed.py").write_text("raise ImportError('No module named distributed')")
    path = os.pathsep.join([str(tmp_path), ENVIRONMENT["PYTHONPATH"]])
    done = bench("run", "cross", "--cluster", "local:1", cwd=tmp_path, PYTHONPATH=path)
    assert_one_line(done, 5, "pip install 'pjpdaf-bench[cluster]'")


def test_a_cluster_that_is_started_here_ends_with_its_command(tmp_path):
    run = ("run", "cross", "--seeds", "1", "--set", "frames=2", "--cluster", "local:2")
    process = started(*run, "--out", "r", cwd=tmp_path)
    _, said = process.communicate(timeout=600)
    assert process.returncode == 0, said
    listing = ["ps", "-o", "stat=,args=", "-g", str(process.pid)]
    found = subprocess.run(listing, capture_output=True, text=True).stdout.splitlines()
    assert [line for line in found if not line.startswith("Z")] == []  # Z: ended, not yet collected
