"""The performer: small motions of the body, and the time that posing takes."""

from __future__ import annotations

import numpy as np
from performances import bodies, cue, drawn, performance

SEEDS = range(5)


def test_the_head_sways_within_its_amplitude(seeds):
    for seed in seeds:
        declared = drawn("speed_ladder", seed)["head_sway"]
        times, posed = bodies("speed_ladder", seed, 0.1)
        heads = np.array([body.head.position_m for body in posed])[times < 1.0]
        assert np.linalg.norm(heads - heads[0], axis=1).max() <= 2 * declared


def test_speed_of_posing(benchmark):
    """Meant to stay below 2 ms on an idle core; reported with --benchmark-enable, never judged."""
    script = performance("bounce", 0).script
    assert benchmark(script.pose, cue(performance("bounce", 0), "touch").from_s).time_s > 0
