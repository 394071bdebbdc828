"""What footage costs from the cache, against rendering it. Ratios within one run.

Run with `pytest tests/bench --benchmark-enable`.
"""

import time

import pytest

from scenarios.spec.draw import perform
from scenarios.spec.names import load_scenario
from sim.recording.recorder import RecordedSimulation
from sim.recording.recording import Recording
from sim.sequence import Simulation

FRAMES = 3


@pytest.fixture(scope="module")
def simulation():
    overrides = {"frames": FRAMES, "background_frames": 0}
    with Simulation(perform(load_scenario("cross"), 100, overrides)) as opened:
        opened.render(0)
        yield opened


def render(simulation):
    assert len(list(simulation.frames())) == FRAMES


def record(simulation, path):
    with path.open("wb") as file:
        recorded = RecordedSimulation(simulation, file, {})
        assert len(list(recorded.frames())) == FRAMES
        assert recorded.complete


def replay(path):
    with Recording(path) as recording:
        assert len(list(recording.frames())) == FRAMES


def test_rendered(benchmark, simulation):
    benchmark.group = "footage"
    benchmark.pedantic(render, args=(simulation,), rounds=3)


def test_rendered_and_recorded(benchmark, simulation, tmp_path):
    benchmark.group = "footage"
    benchmark.pedantic(record, args=(simulation, tmp_path / "a.rec"), rounds=3)


def test_replayed(benchmark, simulation, tmp_path):
    benchmark.group = "footage"
    record(simulation, tmp_path / "a.rec")
    benchmark.pedantic(replay, args=(tmp_path / "a.rec",), rounds=3)


@pytest.mark.long
def test_footage_is_replayed_at_ten_times_the_rate(simulation, tmp_path):
    """CPU time, all threads, which other processes do not change much."""

    def cpu_s(work, *arguments):
        start = time.process_time()
        work(*arguments)
        return time.process_time() - start

    path = tmp_path / "a.rec"
    recorded_s = min(cpu_s(record, simulation, path) for _ in range(3))
    rendered_s = min(cpu_s(render, simulation) for _ in range(3))
    replayed_s = min(cpu_s(replay, path) for _ in range(3))
    assert rendered_s > 10 * replayed_s
    assert recorded_s < 1.1 * rendered_s
