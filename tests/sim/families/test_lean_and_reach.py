"""The torso leans and a hand reaches far out on the table."""

from __future__ import annotations

import numpy as np
import pytest
from performances import bodies, cues, drawn, performance, speeds, truths

SEEDS = range(200, 203)
DT_S = 1.0 / 12.0


def path_of(name, seed):
    """Times (n,) and palms (n, 2, 3) [m] of the whole film."""
    times, posed = bodies(name, seed, DT_S)
    return times, np.array([[arm.palm_m for arm in body.arms] for body in posed])


def test_the_torso_leans_up_to_30_degrees_and_the_head_moves_0_1_to_0_35_m(seeds):
    for seed in seeds:
        values = drawn("lean_and_reach", seed)
        _, posed = bodies("lean_and_reach", seed, DT_S)
        heads = np.array([body.head.position_m for body in posed])
        moved = np.linalg.norm(heads - heads[0], axis=1).max()
        assert 0.10 <= moved <= 0.35
        tilt = max(np.degrees(np.arccos(body.torso.rotation[2, 2])) for body in posed)
        assert np.degrees(values["lean"]) - 1.0 <= tilt <= 32.0


def test_the_reach_goes_far_out_on_the_table_and_comes_back(seeds):
    for seed in seeds:
        values = drawn("lean_and_reach", seed)
        _, path = path_of("lean_and_reach", seed)
        farthest = path[..., 0].max()
        assert 0.9 * values["reach"] <= farthest <= values["reach"] + 0.01
        assert speeds(path, DT_S).max() == pytest.approx(values["speed"], rel=0.1)
        played = performance("lean_and_reach", seed)
        assert len(cues(played, "leant")) == round(values["reaches"])
        script, last = played.script, cues(played)[-1].to_s
        after = script.body(last + 0.1)
        before = script.body(0.0)
        for one, other in zip(after.arms, before.arms, strict=True):
            np.testing.assert_allclose(one.palm_m, other.palm_m, atol=1e-6)


def test_the_far_hand_is_in_the_picture():
    played = performance("lean_and_reach", 200)
    leant = cues(played, "leant")[0]
    (views,) = truths(played, [0.5 * (leant.from_s + leant.to_s)])
    for view in views:
        assert (view.amodal_px > 500).all()
        assert (view.visible_fractions > 0.7).all()
