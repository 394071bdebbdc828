"""Hands that go side by side."""

from __future__ import annotations

import numpy as np
import pytest
from performances import cue, drawn, gap_m, palms, performance

SEEDS = range(4)


def test_parallel_hands_keep_their_gap_and_move_as_one_at_the_declared_speed(seeds):
    for seed in seeds:
        values = drawn("parallel", seed)
        played = performance("parallel", seed)
        together, script = cue(played, "parallel"), played.script
        times = np.arange(together.from_s, together.to_s, 0.05).tolist()
        # Each hand's tremor is at most 3 mm.
        gaps = np.array([gap_m(script, t) for t in times[::3]])
        assert np.abs(gaps - values["gap"]).max() < 0.01
        assert 0.05 < gaps.min() < gaps.max() < 0.11
        path = palms(script, times)
        apart = path[:, 0] - path[:, 1]
        assert np.ptp(apart, axis=0).max() < 0.014
        speed = np.linalg.norm(np.diff(path.mean(axis=1), axis=0), axis=1) / 0.05
        assert speed.max() == pytest.approx(values["speed"], rel=0.12, abs=0.02)
        assert np.ptp(path[:, 0, 1]) > 0.1  # to and fro, far enough to see
        part = cue(played, "part")
        assert np.linalg.norm(np.diff(palms(script, [part.to_s])[0], axis=0)) > 0.3
