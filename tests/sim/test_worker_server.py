"""The server that workers are forked from: what they take over, and what happens when it ends."""

import os
import signal
import threading
import time
from pathlib import Path

import pytest
from commands import server_pids, wait_until, worker_pids
from worker_tasks import double, pid, random_number, slow_and_large, surroundings

from scenarios.execute.local import PLAYED_WITH
from sim.processes import Answer, WorkerPool
from sim.worker_server import terminal_signals_blocked

# Modules with the tasks of all pools of ours.
TASKS = (
    *PLAYED_WITH,
    "scenarios.catalogue.pictures",
    "scenarios.dataset.sequence_task",
    "scenarios.execute.isolated",
    "scenarios.stress.recording",
    "scenarios.stress.trials",
    "sim.dataset.verify",
)
# Threads of libraries that take care of a fork themselves: pyarrow's jemalloc.
HARMLESS = {"jemalloc_bg_thd"}


def answers(function, tasks, workers=1, **options):
    with WorkerPool(workers, **options) as pool:
        ended = [pair for pair in pool.outcomes(function, tasks, 60.0) if pair]
    return [outcome.value for _, outcome in sorted(ended)]


def test_it_has_neither_opengl_nor_threads():
    assert answers(double, {0: 1}, modules=TASKS) == [2]
    (server,) = server_pids(os.getpid())
    libraries = Path(f"/proc/{server}/maps").read_text()
    for name in ("libEGL", "libGL", "libOSMesa", "libOpenGL", "libgallium", "libmujoco"):
        assert name not in libraries
    assert "libcrypto" in libraries or "_multiarray_umath" in libraries  # the modules are there
    threads = [
        (path / "comm").read_text().strip() for path in Path(f"/proc/{server}/task").iterdir()
    ]
    assert len(threads) - sum(name in HARMLESS for name in threads) == 1, threads


def test_workers_have_imported_the_modules():
    (loaded,) = answers(surroundings, {0: "modules"}, modules=TASKS)
    assert {*TASKS} <= {*loaded}


def test_a_worker_takes_over_folder_path_and_variables_of_its_parent(tmp_path, monkeypatch):
    server = {*server_pids(os.getpid())}
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setenv("PJPDAF_BENCH_CACHE", "here")
    (seen,) = answers(surroundings, {0: "PJPDAF_BENCH_CACHE"})
    assert seen == (str(tmp_path), str(tmp_path), "here")
    monkeypatch.delenv("PJPDAF_BENCH_CACHE")
    assert answers(surroundings, {0: "PJPDAF_BENCH_CACHE"})[0][2] is None
    assert server <= {*server_pids(os.getpid())}


def test_a_variable_that_libraries_read_when_they_are_loaded_starts_a_new_server(monkeypatch):
    answers(double, {0: 1})
    before = server_pids(os.getpid())
    monkeypatch.setenv("OMP_NUM_THREADS", "3")
    assert answers(surroundings, {0: "OMP_NUM_THREADS"})[0][2] == "3"
    after = server_pids(os.getpid())
    assert len(after) == 1
    assert before != after


def test_workers_draw_different_random_numbers():
    one, two = answers(random_number, {0: 0, 1: 0}, workers=1, tasks_per_worker=1)
    assert one != two


def lives(number):
    try:
        os.kill(number, 0)
    except ProcessLookupError:
        return False
    return True


@pytest.mark.parametrize("at", [0, 3])
def test_a_server_that_is_killed_loses_no_answer(at):
    """And its workers end with it."""
    found, workers = {}, []
    with WorkerPool(2) as pool:
        for pair in pool.outcomes(slow_and_large, {n: n for n in range(8)}, 60.0, attempts=9):
            if pair:
                found.update([pair])
            if len(found) == at and not workers:
                workers = worker_pids(os.getpid())
                os.kill(server_pids(os.getpid())[0], signal.SIGKILL)
        assert found == {n: Answer(bytes([n]) * 3_000_000) for n in range(8)}
        assert not {*workers} & {*worker_pids(os.getpid())}
    for number in workers:
        wait_until(lambda number=number: not lives(number))


def test_each_worker_is_a_process_of_its_own():
    pids = answers(pid, {0: 0, 1: 0}, tasks_per_worker=1)
    assert len({*pids, os.getpid(), *server_pids(os.getpid())}) == 4


def test_a_handler_waits_for_the_end_of_a_start_though_another_thread_is_sent_the_signal():
    there, done, passed = threading.Event(), threading.Event(), []
    other = threading.Thread(target=lambda: (there.set(), done.wait()))
    other.start()  # before the block: it blocks no signal
    there.wait()

    def starts():
        with terminal_signals_blocked():
            signal.pthread_kill(other.ident, signal.SIGINT)
            time.sleep(0.05)
            passed.append(True)

    with pytest.raises(KeyboardInterrupt):
        starts()
    done.set()
    other.join()
    assert passed
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
