"""Bad starts: where the hands are, that they come from there smoothly, that the plan follows."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from pjpdaf.targets import LEFT_HAND, RIGHT_HAND
from scenarios.spec.draw import perform
from scenarios.spec.names import load_scenario
from sim.camera.render import StereoRenderer
from sim.motion.measure import fault_of, measure
from sim.motion.motion import Performer
from sim.motion.opening import MOVE_S, OPENING_S, OPENINGS, with_opening
from sim.motion.stage import Stage
from sim.randomness import generator
from sim.scene.world import build

SEEDS = range(100, 105)
NAMES = ("cross", "calm_table", "drink")
BAD = tuple(kind for kind in OPENINGS if kind != "apart")

every = pytest.mark.parametrize("kind", BAD)


@cache
def planned(name, seed):
    """A performer without an opening, and the stage to open it on."""
    played = perform(load_scenario(name), seed)
    stage = Stage(
        scene=played.scene, values={}, streams=lambda s: generator(seed, s), duration_s=16.0
    )
    return played.script, stage


@cache
def opened(name, seed, kind):
    performer, stage = planned(name, seed)
    return Performer(performer.scene, with_opening(stage, performer.plan, kind))


def later(kind):
    return OPENING_S + MOVE_S + (0.15 if kind == "crossed" else 0.0)


def test_apart_is_the_plan_itself():
    performer, stage = planned("cross", 100)
    assert with_opening(stage, performer.plan, "apart") is performer.plan


def test_an_unknown_word_is_refused():
    performer, stage = planned("cross", 100)
    with pytest.raises(ValueError, match="start must be one of apart, crossed, hidden, got 'up'"):
        with_opening(stage, performer.plan, "up")


@pytest.mark.long
@every
@pytest.mark.parametrize("name", NAMES)
def test_a_person_can_make_every_opening(name, kind, seeds):
    for seed in seeds:
        performer = opened(name, seed, kind)
        times = np.arange(0.0, later(kind) + 0.3, 1 / 15).tolist()
        assert fault_of(performer, times) is None
        speeds = measure(performer, times).speeds
        assert max(s.top_mps for s in speeds.values()) < 2.5


@every
def test_the_plan_follows_unchanged_but_later(kind):
    performer, _ = planned("drink", 100)
    bad = opened("drink", 100, kind)
    wait = later(kind)
    for t in np.linspace(0.0, 12.0, 25).tolist():
        for before, after in zip(performer.plan.hands, bad.plan.hands, strict=True):
            # t + wait - wait is t but for rounding.
            moved = after.at(t + wait).position_m - before.at(t).position_m
            assert np.abs(moved).max() < 1e-9
    for before, after in zip(performer.plan.holds, bad.plan.holds, strict=True):
        assert (after.name, after.side) == (before.name, before.side)
        np.testing.assert_allclose(
            [after.from_s, after.to_s], [before.from_s + wait, before.to_s + wait]
        )
    first, *others = bad.plan.cues
    assert (first.name, first.from_s, first.to_s) == (f"start:{kind}", 0.0, OPENING_S)
    assert [c.name for c in others] == [c.name for c in performer.plan.cues]


@every
def test_told_paths_have_no_jumps_of_speed(kind, seeds):
    for seed in seeds:
        for hand in opened("cross", seed, kind).plan.hands:
            times = np.arange(0.0, later(kind) + 0.5, 0.002)
            path = np.array([hand.at(t).position_m for t in times])
            velocity = np.diff(path, axis=0) / 0.002
            assert np.abs(np.diff(velocity, axis=0)).max() < 0.06  # 30 m/s2
            still = times[:-1] < OPENING_S - 0.01
            assert np.abs(velocity[still]).max() == 0.0


@pytest.mark.long
def test_crossed_hands_are_on_the_wrong_sides_one_over_the_other():
    tops = set()
    for seed in SEEDS:
        right, left = (arm.palm_m for arm in opened("cross", seed, "crossed").body(0.0).arms)
        assert right[1] > 0.05
        assert left[1] < -0.05
        assert abs(right[2] - left[2]) > 0.05
        tops.add(bool(right[2] > left[2]))
    assert len(tops) == 2  # by chance


def test_a_hidden_hand_shows_no_skin_and_the_other_one_does():
    for seed in SEEDS[:3]:
        performer = opened("cross", seed, "hidden")
        world = build(performer.scene)
        with StereoRenderer(world) as renderer:
            for t, hidden in ((0.0, True), (OPENING_S, True), (later("hidden"), False)):
                world.place(performer.pose(t))
                for view in renderer.render(colour=False, amodal=False):
                    seen = sorted(int((view.targets == h).sum()) for h in (RIGHT_HAND, LEFT_HAND))
                    assert (seen[0] == 0) == hidden
                    assert seen[1] > 1000
