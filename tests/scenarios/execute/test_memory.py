"""The memory of a worker does not grow with the episodes that it has played."""

import pytest
from worker_tasks import memory_after

from scenarios.execute.local import local_executor
from scenarios.play.job import Job, System
from scenarios.spec.names import load_scenario
from sim.processes import Answer

MOST_MB = 500
GROWTH_MB = 15


def memory(jobs):
    """(now, at most) [MB] of a worker after each of these jobs."""
    with local_executor(1) as executor:
        ended = [pair for pair in executor.outcomes(memory_after, jobs, 300.0) if pair]
    assert all(isinstance(outcome, Answer) for _, outcome in ended)
    (pid,) = {outcome.value[0] for _, outcome in ended}
    assert pid > 0
    return [outcome.value[1:] for _, outcome in sorted(ended)]


def episodes(count, seeds, size, **overrides):
    """Jobs of the first seeds again and again."""
    cross = load_scenario("cross")
    return {n: Job(cross, 100 + n % seeds, overrides, System(), size_px=size) for n in range(count)}


@pytest.mark.long
def test_of_rendered_episodes():
    used = memory(episodes(4, 1, (160, 120), frames=2, background_frames=10))
    assert used[3][0] < used[1][0] + GROWTH_MB


@pytest.mark.long
def test_of_rendered_episodes_of_the_whole_size():
    used = memory(episodes(40, 40, None, frames=3))
    report(used, (1, 10, 20, 40))
    assert used[-1][0] < used[9][0] + GROWTH_MB
    assert used[-1][1] < MOST_MB


@pytest.mark.long
def test_of_two_thousand_episodes(tmp_path, monkeypatch):
    monkeypatch.setenv("PJPDAF_BENCH_CACHE", str(tmp_path))
    used = memory(episodes(2000, 20, (96, 72), frames=4, background_frames=10))
    report(used, (1, 100, 500, 1000, 2000))
    assert used[-1][0] < used[99][0] + GROWTH_MB
    assert used[-1][1] < MOST_MB


def report(used, counts):
    for n in counts:
        print(f"after {n} episodes {used[n - 1][0]:.0f} MB, at most {used[n - 1][1]:.0f} MB")
