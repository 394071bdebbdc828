"""The performer: small motions of the body, and the time that posing takes."""

from __future__ import annotations

import numpy as np
from performances import bodies, cue, drawn, performance

from sim.motion.motion import elbow_floor, elbow_floor_over

SEEDS = range(5)


def test_the_head_sways_within_its_amplitude(seeds):
    for seed in seeds:
        declared = drawn("speed_ladder", seed)["head_sway"]
        times, posed = bodies("speed_ladder", seed, 0.1)
        heads = np.array([body.head.position_m for body in posed])[times < 1.0]
        assert np.linalg.norm(heads - heads[0], axis=1).max() <= 2 * declared


def test_elbow_floors_of_many_palms_are_those_of_each():
    performer = performance("cross", 0).script
    anatomy, table = performer.scene.anatomy, performer.table
    spread = np.random.default_rng(0).uniform(-0.15, 0.15, (200, 3))
    palms = np.array([table.near_x_m, 0.0, table.top_m]) + spread
    floors = elbow_floor_over(anatomy, table, palms)
    np.testing.assert_array_equal(floors, [elbow_floor(anatomy, table, p) for p in palms])
    assert len(np.unique(floors)) > 50


def test_speed_of_posing(benchmark):
    """Meant to stay below 2 ms on an idle core; reported with --benchmark-enable, never judged."""
    script = performance("bounce", 0).script
    assert benchmark(script.pose, cue(performance("bounce", 0), "touch").from_s).time_s > 0
