"""Workers that are killed, hang, or raise; the rest go on."""

import os
import random
import signal
import threading
from contextlib import suppress

import pytest
from commands import worker_pids
from worker_tasks import (
    SlowToArrive,
    answers,
    cannot_be_sent,
    counts_steps,
    dies,
    dies_once,
    double,
    fails,
    hangs,
    memory_with_holes,
    pid,
    prints_among_messages,
    slow_and_large,
    starts_a_process,
)

from sim.processes import ATTEMPTS, Answer, Lost, WorkerPool


@pytest.fixture(autouse=True)
def others():
    """Workers that are not those of the test; these are gone at its end."""
    before = set(worker_pids(os.getpid()))
    yield before
    assert set(worker_pids(os.getpid())) <= before


def outcomes(function, tasks, workers=2, limit_s=60.0, **options):
    before = set(worker_pids(os.getpid()))
    with WorkerPool(workers) as pool:
        outcomes = [pair for pair in pool.outcomes(function, tasks, limit_s, **options) if pair]
    assert set(worker_pids(os.getpid())) <= before
    return dict(outcomes)


def test_every_task_has_its_answer():
    tasks = {7 * n: n for n in range(9)}
    assert outcomes(double, tasks) == {7 * n: Answer(2 * n) for n in range(9)}


def test_what_a_task_prints_goes_to_standard_error():
    assert outcomes(prints_among_messages, {0: 0}) == {0: Answer(True)}


def test_a_worker_that_died_once_says_so():
    assert Lost(late=False, attempts=1, exit_code=7).death == "its worker died once (exit code 7)"
    assert Lost(late=False, attempts=3).death == "its worker died 3 times"


def test_a_task_that_kills_its_worker_is_lost_and_the_others_are_not():
    found = outcomes(dies, {n: n for n in range(5)})
    assert found.pop(1) == Lost(late=False, attempts=ATTEMPTS, exit_code=-signal.SIGKILL)
    assert found == {n: Answer(2 * n) for n in (0, 2, 3, 4)}


def test_a_task_whose_worker_died_is_done_again(tmp_path):
    assert outcomes(dies_once, {0: str(tmp_path / "mark")}) == {0: Answer("again")}
    mark = str(tmp_path / "other")
    once = outcomes(dies_once, {0: mark}, attempts=1)
    assert once == {0: Lost(late=False, attempts=1, exit_code=3)}


def test_a_task_that_hangs_is_late_and_the_others_are_not():
    found = outcomes(hangs, {n: n for n in range(4)}, limit_s=3.0)
    assert found.pop(1).late
    assert found == {n: Answer(n) for n in (0, 2, 3)}


def test_what_a_task_raises_comes_out():
    with pytest.raises(KeyError, match="one"):
        outcomes(fails, {n: n for n in range(4)})
    with pytest.raises(RuntimeError, match="its answer cannot be sent"):
        outcomes(cannot_be_sent, {0: 0})


def test_the_limit_is_of_the_task_alone():
    found = outcomes(answers, {0: SlowToArrive()}, limit_s=0.5)
    assert found == {0: Answer(None)}


def test_it_goes_on_after_an_exception_and_after_it_was_closed():
    with WorkerPool(2) as pool:
        with pytest.raises(KeyError, match="one"):
            list(pool.outcomes(fails, {n: n for n in range(4)}, 60.0))
        again = dict(pair for pair in pool.outcomes(double, {0: 1, 1: 2}, 60.0) if pair)
        assert again == {0: Answer(2), 1: Answer(4)}
        unfinished = pool.outcomes(hangs, {n: n for n in range(4)}, 60.0)
        next(pair for pair in unfinished if pair)
        unfinished.close()
        pool.close()
        last = dict(pair for pair in pool.outcomes(double, {5: 1}, 60.0) if pair)
        assert last == {5: Answer(2)}


def test_a_worker_is_replaced_after_so_many_tasks():
    with WorkerPool(1, tasks_per_worker=2) as pool:
        pairs = [pair for pair in pool.outcomes(pid, dict.fromkeys(range(6)), 60.0) if pair]
    pids = [answer.value for _, answer in pairs]
    assert len(set(pids)) == 3
    assert all(pids.count(one) == 2 for one in pids)


def test_a_task_may_start_processes_of_its_own():
    assert outcomes(starts_a_process, {0: 0}) == {0: Answer(0)}


def test_workers_killed_at_random_moments_lose_no_answer(others):
    """While they start, wait, work, and in the middle of their answers."""
    rng, over = random.Random(1), threading.Event()

    def killer():
        kills = 0  # an end to them: where workers start slowly, hardly a task would be finished
        while kills < 15 and not over.wait(rng.uniform(0.05, 0.5)):
            pids = [pid for pid in worker_pids(os.getpid()) if pid not in others]
            if pids:
                with suppress(ProcessLookupError):
                    os.kill(rng.choice(pids), signal.SIGKILL)
                    kills += 1

    thread = threading.Thread(target=killer)
    with WorkerPool(2) as pool:
        thread.start()
        try:
            tasks = {n: n for n in range(30)}
            found = dict(o for o in pool.outcomes(slow_and_large, tasks, 60.0, attempts=99) if o)
        finally:
            over.set()
            thread.join()
    assert found == {n: Answer(bytes([n]) * 3_000_000) for n in range(30)}


def test_steps_are_known_while_their_task_goes_on(tmp_path):
    end, heard = tmp_path / "end", []
    with WorkerPool(1) as pool:
        for ended in pool.outcomes(counts_steps, {0: str(end)}, 60.0):
            heard.append(pool.running_steps())
            if ended is None and heard[-1] == 2:
                end.touch()
    assert 2 in heard
    assert heard[-1] == 0


def test_free_memory_is_given_back_where_there_is_much():
    ended = outcomes(memory_with_holes, {0: 1e6, 1: 0.0}, workers=1)
    (before, kept), (full, left) = (ended[n].value for n in range(2))
    assert kept == pytest.approx(before, abs=2)
    assert left < full - 70
