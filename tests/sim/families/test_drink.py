"""Drinking from a can."""

from __future__ import annotations

import numpy as np
import pytest
from performances import HANDS, bodies, cue, drawn, performance, speeds

from sim.vectors import norm

SEEDS = range(5)


def path_of(name, seed):
    """Times (n,) and palms (n, 2, 3) [m] of the whole film, 0.1 s apart."""
    times, posed = bodies(name, seed, 0.1)
    return times, np.array([[arm.palm_m for arm in body.arms] for body in posed])


def test_drink_reaches_at_the_declared_speed_and_takes_16_to_20_s(seeds):
    for seed in seeds:
        values = drawn("drink", seed)
        _, path = path_of("drink", seed)
        side = HANDS.index(values["hand"])
        assert speeds(path, 0.1)[:, side].max() == pytest.approx(values["speed"], rel=0.08)
        assert speeds(path, 0.1)[:, 1 - side].max() < 0.02
        played = performance("drink", seed)
        assert 16.0 <= played.frames / played.fps <= 20.0


def test_the_can_stands_goes_with_the_hand_and_stands_again(seeds):
    for seed in seeds:
        script = performance("drink", seed).script
        (hold,) = script.plan.holds
        top = script.scene.room.table_height_m
        for t in (0.0, hold.from_s - 0.01, hold.to_s + 0.01, 17.0):
            can = script.pose(t).objects["can"]
            assert can.position_m[2] == top
            assert can.rotation[2, 2] == 1.0
        grips = []
        for t in np.linspace(hold.from_s, hold.to_s - 1e-6, 9).tolist():
            pose = script.pose(t)
            hand, can = pose.hands[hold.side], pose.objects["can"]
            grips.append(hand.rotation.T @ (can.position_m - hand.position_m))
            assert can.position_m[2] > top - 0.002
        np.testing.assert_allclose(grips, np.broadcast_to(grips[0], (9, 3)), atol=1e-9)
        for t in (hold.from_s, hold.to_s):
            before = script.pose(t - 1e-6).objects["can"].position_m
            assert norm(script.pose(t + 1e-6).objects["can"].position_m - before) < 0.002


def test_the_can_is_held_to_the_mouth_for_about_eight_frames(seeds):
    for seed in seeds:
        played = performance("drink", seed)
        drink = cue(performance("drink", seed), "drink")
        assert 1.5 <= drink.to_s - drink.from_s <= 5.0
        pose = played.script.pose(drink.from_s + 1.0)
        anatomy, can = played.scene.anatomy, pose.objects["can"]
        mouth = pose.head.position_m + pose.head.rotation @ np.array(
            [0.5 * anatomy.head_depth_m, 0.0, -0.26 * anatomy.head_height_m]
        )
        rim = can.position_m + 0.122 * can.rotation[:, 2]
        assert norm(rim - mouth) < 0.05
        assert can.rotation[0, 2] < -0.3  # the top leans towards the face
        hold = played.script.plan.holds[0]
        assert (pose.curls[hold.side, 1:] > 0.3).all()
