"""Cross and bounce: one approach, two outcomes that nobody can tell until they happen."""

from __future__ import annotations

import math

import numpy as np
import pytest
from performances import (
    assert_same,
    bodies,
    cue,
    drawn,
    performance,
    same_pictures,
    speeds,
    truths,
)

from scenarios.spec.draw import perform
from scenarios.spec.names import load_scenario
from sim.contact.contact import penetration
from sim.sequence import Simulation
from sim.vectors import norm

SEEDS = range(5)


@pytest.mark.long
@pytest.mark.parametrize("seed", [0, 1])
def test_twins_show_the_same_pictures_until_the_hands_merge(seed):
    """Up to the frame before the first that differs; by then the hands have merged."""
    cross, bounce = (performance(name, seed) for name in ("cross", "bounce"))
    split_s = cue(cross, "cross").from_s
    assert split_s == pytest.approx(cue(bounce, "bounce").from_s, abs=1e-9)
    last = math.ceil(split_s * cross.fps) - 1
    with Simulation(cross) as one, Simulation(bounce) as other:
        for index in (last // 2, last - 1, last):
            assert same_pictures(one.render(index), other.render(index))
        assert not same_pictures(one.render(last + 1), other.render(last + 1))
    # At the very moment at which they go separate ways both views show one blob.
    (views,) = truths(cross, [math.ceil(split_s * 30) / 30])
    assert [bool(view.merged[1, 2]) for view in views] == [True, True]


def path_of(name, seed):
    """Times (n,) and palms (n, 2, 3) [m] of the whole film, 0.1 s apart."""
    times, posed = bodies(name, seed, 0.1)
    return times, np.array([[arm.palm_m for arm in body.arms] for body in posed])


@pytest.mark.parametrize("name", ["cross", "bounce"])
def test_crossing_hands_pass_the_middle_at_the_declared_speed(name, seeds):
    for seed in seeds:
        declared = drawn(name, seed)["speed"]
        played = performance(name, seed)
        event = cue(performance("bounce", seed), "bounce")
        times = np.arange(event.from_s - 0.4, event.from_s, 0.01).tolist()
        path = np.array([[a.palm_m for a in played.script.body(t).arms] for t in times])
        # The approach is broken off near the middle of the stroke: most of the peak is reached.
        assert 0.6 * declared <= speeds(path, 0.01).max() <= 1.05 * declared + 0.02


def test_cross_changes_sides_and_holds_and_bounce_does_not(seeds):
    for seed in seeds:
        crossed = cue(performance("cross", seed), "crossed")
        assert crossed.to_s - crossed.from_s >= 0.5
        script = performance("cross", seed).script
        for t in np.linspace(crossed.from_s, crossed.to_s, 5).tolist():
            right, left = script.body(t).arms
            assert right.palm_m[1] > 0.08
            assert left.palm_m[1] < -0.08
        _, path = path_of("bounce", seed)
        assert (path[:, 0, 1] < 0).all()
        assert (path[:, 1, 1] > 0).all()


def test_cross_keeps_its_declared_speed_all_the_way(seeds):
    for seed in seeds:
        declared = drawn("cross", seed)["speed"]
        event, script = cue(performance("cross", seed), "cross"), performance("cross", seed).script
        times = np.arange(event.from_s, event.to_s, 0.02).tolist()
        path = np.array([[a.palm_m for a in script.body(t).arms] for t in times])
        assert speeds(path, 0.02).max() == pytest.approx(declared, rel=0.1, abs=0.02)


def test_bounce_touches(seeds):
    for seed in seeds:
        script = performance("bounce", seed).script
        touch = cue(performance("bounce", seed), "touch")
        body = script.body(touch.from_s + 0.01)
        gap = penetration(
            script.scene.anatomy, body.arms, body.curls, script.obstacles(body.torso, body.head)
        )
        assert -0.012 <= gap.hands_m <= 0.005


def test_cross_and_bounce_are_one_scene_until_the_hands_merge(seeds):
    for seed in seeds:
        cross, bounce = performance("cross", seed), performance("bounce", seed)
        assert cross.scene == bounce.scene
        merge_s = cue(performance("bounce", seed), "bounce").from_s
        assert merge_s == pytest.approx(cue(performance("cross", seed), "cross").from_s, abs=1e-9)
        for t in np.append(np.arange(0.0, merge_s, 0.25), merge_s - 1e-6).tolist():
            assert_same(cross.script.pose(t), bounce.script.pose(t))
        later = merge_s + 0.5
        moved = cross.script.body(later).arms[0].palm_m - bounce.script.body(later).arms[0].palm_m
        assert norm(moved) > 0.01


def test_hands_that_brush_past_each_other_still_move_smoothly():
    """A gap so small that contact projection works in the middle of the stroke."""
    played = perform(load_scenario("cross"), 2, {"depth_gap": 0.055, "speed": 0.3, "bow": 0.0})
    event = next(cue for cue in played.script.plan.cues if cue.name == "cross")
    times = np.arange(event.from_s, event.to_s, 0.02).tolist()
    path = np.array([[a.palm_m for a in played.script.body(t).arms] for t in times])
    assert speeds(path, 0.02).max() < 0.9  # no jump: 0.3 m/s, and the way round the other
