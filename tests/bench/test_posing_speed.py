"""What a pose and the judging of a draw cost. Reported, never judged by the clock.

Run with `pytest tests/bench --benchmark-enable`. Meant, on an idle core: a pose in 2 ms, 60 frames
judged in 0.25 s.
"""

from __future__ import annotations

import numpy as np
import pytest

from scenarios.spec.draw import perform
from scenarios.spec.names import load_scenario
from sim.motion.measure import fault_of, measure
from sim.motion.motion import performer_of

# At rest, at work, touching, arms crossed, both hands on the head.
MOMENTS = ("one_hand_idle", "natural_table", "bounce", "cross", "both_hands_to_head")


@pytest.fixture(scope="module")
def performers():
    played = {name: perform(load_scenario(name), 100) for name in MOMENTS}
    return {name: performer_of(performance.script) for name, performance in played.items()}


@pytest.mark.parametrize("name", MOMENTS)
def test_posing_60_frames(benchmark, performers, name):
    benchmark.group = "pose 60 frames"
    performer, times = performers[name], np.linspace(0.0, 13.0, 60).tolist()
    bodies = benchmark(lambda: [performer.body(t) for t in times])
    assert len(bodies) == 60


@pytest.mark.parametrize("name", MOMENTS)
def test_judging_60_frames(benchmark, performers, name):
    benchmark.group = "judge 60 frames"
    assert benchmark(fault_of, performers[name], np.linspace(0.0, 13.0, 60).tolist()) is None


def test_measuring_60_frames(benchmark, performers):
    benchmark.group = "measure 60 frames"
    found = benchmark(measure, performers["cross"], np.linspace(0.0, 13.0, 60).tolist())
    assert found.deepest_m <= 0.005
