"""Identity traps, and the twins cross and bounce: what nobody can tell until it has happened."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest

from scenarios.spec.draw import concrete, perform
from scenarios.spec.names import load_scenario
from sim.contact.contact import penetration
from sim.sequence import Simulation

NAMES = ("mirror", "swap_hidden", "parallel")
SEEDS = range(4)

every = pytest.mark.parametrize("name", NAMES)


@cache
def performance(name, seed):
    return perform(load_scenario(name), seed)


def cues(played):
    return {cue.name: cue for cue in played.script.plan.cues}


def palms(script, times):
    return np.array([[arm.palm_m for arm in script.body(t).arms] for t in times])


def gap_m(script, t_s):
    """Air between the hands [m], negative where they overlap."""
    body = script.body(t_s)
    obstacles = script.obstacles(body.torso, body.head)
    return -penetration(script.scene.anatomy, body.arms, body.curls, obstacles).hands_m


def same_pictures(a, b):
    return all(
        np.array_equal(first, second)
        for first, second in zip(a.frame.pictures, b.frame.pictures, strict=True)
    )


def merged(shot):
    """Whether the hands are one blob, per view."""
    return [bool(view.merged[1, 2]) for view in shot.truth.views]


@every
def test_draws_can_be_posed_and_end_within_the_frames(name, seeds):
    for seed in seeds:
        played = performance(name, seed)
        assert played.redrawn == 0
        assert max(cue.from_s for cue in played.script.plan.cues) < played.frames / played.fps - 2.0
        assert 40 <= played.frames <= 150


@every
def test_the_first_second_shows_two_still_hands_apart(name, seeds):
    for seed in seeds:
        first = palms(performance(name, seed).script, np.linspace(0.0, 1.0, 6).tolist())
        assert np.ptp(first, axis=0).max() < 1e-9
        assert np.linalg.norm(first[0, 0] - first[0, 1]) >= 0.25


@every
def test_hands_move_without_jumps(name, seeds):
    for seed in seeds:
        script = performance(name, seed).script
        joints = [t for cue in script.plan.cues for t in (cue.from_s, cue.to_s)]
        before = np.append(np.arange(0.5, 15.0, 0.13), np.array(joints) - 5e-4)
        moved = palms(script, (before + 1e-3).tolist()) - palms(script, before.tolist())
        assert np.linalg.norm(moved, axis=-1).max() < 1.2e-3


@every
def test_the_motion_is_the_same_at_any_frame_rate(name):
    slow = perform(load_scenario(name), 3, {"fps": 1, "frames": 40})
    fast = perform(load_scenario(name), 3, {"fps": 30, "frames": 1200})
    for t in (2.0, 4.5, 7.25, 15.0):
        a, b = slow.script.pose(t), fast.script.pose(t)
        for side in (0, 1):
            np.testing.assert_array_equal(a.hands[side].position_m, b.hands[side].position_m)
            np.testing.assert_array_equal(a.hands[side].rotation, b.hands[side].rotation)


@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.long)])
def test_twins_show_the_same_pictures_until_the_hands_merge(seed):
    """Up to the frame before the first that differs; by then the hands have merged."""
    cross, bounce = (perform(load_scenario(name), seed) for name in ("cross", "bounce"))
    split_s = cues(cross)["cross"].from_s
    assert split_s == pytest.approx(cues(bounce)["bounce"].from_s, abs=1e-9)
    last = math.ceil(split_s * cross.fps) - 1
    with Simulation(cross) as one, Simulation(bounce) as other:
        for index in (last // 2, last - 1, last):
            assert same_pictures(one.render(index), other.render(index))
        assert not same_pictures(one.render(last + 1), other.render(last + 1))
    # At the very moment at which they go separate ways both views show one blob.
    fine = perform(load_scenario("cross"), seed, {"fps": 30, "frames": 480})
    with Simulation(fine) as simulation:
        assert merged(simulation.render(math.ceil(split_s * 30))) == [True, True]


def test_mirrored_hands_meet_5_to_10_times_and_cross_or_return_by_a_coin():
    kinds = []
    for seed in range(5):
        played = performance("mirror", seed)
        values = concrete(load_scenario("mirror"), seed)
        script = played.script
        meetings = script.plan.cues
        assert len(meetings) == round(values["meetings"])
        assert 5 <= len(meetings) <= 10
        right_is_right = True
        for k, cue in enumerate(meetings):
            kind, number = cue.name.split(":")
            assert int(number) == k + 1
            kinds.append(kind)
            right_is_right ^= kind == "cross"
            later = (meetings[k + 1].from_s + cue.to_s) / 2 if k + 1 < len(meetings) else cue.to_s
            right, left = palms(script, [later])[0]
            assert (right[1] < left[1]) == right_is_right
            assert abs(right[1] + left[1]) < 0.015  # mirror images but for the tremor
    assert 0.3 < kinds.count("cross") / len(kinds) < 0.7


def test_up_to_a_merge_nobody_can_tell_whether_mirrored_hands_will_cross():
    seed, fine = 1, {"fps": 30, "frames": 1200}
    crossing, returning = (
        perform(load_scenario("mirror"), seed, {**fine, "cross_share": share})
        for share in (1.0, 0.0)
    )
    split_s = cues(crossing)["cross:1"].from_s
    assert split_s == cues(returning)["return:1"].from_s
    for t in np.linspace(0.0, split_s, 12).tolist():
        np.testing.assert_array_equal(palms(crossing.script, [t]), palms(returning.script, [t]))
    with Simulation(crossing) as one, Simulation(returning) as other:
        before, after = math.floor(split_s * 30), math.ceil(split_s * 30)
        assert same_pictures(one.render(before), other.render(before))
        assert merged(one.render(after)) == merged(other.render(after)) == [True, True]
        # From the other sides as well: the second meeting of hands that crossed.
        second = math.ceil(cues(crossing)["cross:2"].from_s * 30)
        assert merged(one.render(second)) == [True, True]


@pytest.mark.parametrize("outcome", ["crossed", "same"])
def test_a_screen_hides_both_hands_in_both_views_and_shows_them_before_and_after(outcome):
    played = perform(load_scenario("swap_hidden"), 2, {"outcome": outcome})
    hidden, out = cues(played)["hidden"], cues(played)[f"out:{outcome}"]
    first, last = math.ceil(hidden.from_s * 3), math.floor(hidden.to_s * 3)
    with Simulation(played) as simulation:
        for index in (first, (first + last) // 2, last):
            for view in simulation.render(index).truth.views:
                assert (view.visible_fractions[1:] < 0.1).all()
                assert view.visible_fractions[0] > 0.95  # the face is not cut
        for index in (0, math.ceil(out.from_s * 3)):
            for view in simulation.render(index).truth.views:
                assert (view.visible_fractions > 0.6).all()


def test_hands_are_out_of_sight_for_1_to_4_s():
    for seed, hidden_s in ((0, 0.7), (1, 3.2)):
        fps = 6
        played = perform(
            load_scenario("swap_hidden"), seed, {"fps": fps, "frames": 96, "hidden": hidden_s}
        )
        hidden = cues(played)["hidden"]
        edge = range(math.floor((hidden.from_s - 1.0) * fps), math.ceil(hidden.from_s * fps))
        with Simulation(played) as simulation:
            unseen = sum(
                all(
                    (view.visible_fractions[1:] < 0.1).all()
                    for view in simulation.render(index).truth.views
                )
                for index in edge
            )
        # The way out is the way in reversed: the same time again.
        total_s = hidden.to_s - hidden.from_s + 2 * unseen / fps
        assert 0.9 <= total_s <= 4.4


def test_swapped_hands_do_not_touch_and_come_out_at_the_same_places(seeds):
    ends = {}
    for outcome in ("crossed", "same"):
        for seed in seeds:
            played = perform(load_scenario("swap_hidden"), seed, {"outcome": outcome})
            hidden, out = cues(played)["hidden"], cues(played)[f"out:{outcome}"]
            times = np.arange(hidden.from_s - 1.0, out.from_s + 0.5, 0.1).tolist()
            assert min(gap_m(played.script, t) for t in times) > 0.0
            right, left = palms(played.script, [out.from_s + 0.5])[0]
            assert (right[1] > left[1]) == (outcome == "crossed")
            ends[outcome, seed] = sorted([right[1], left[1]])
            assert f"out:{outcome}" in played.script.events(out.from_s)
    for seed in seeds:
        np.testing.assert_allclose(ends["crossed", seed], ends["same", seed], atol=0.008)


def test_half_of_the_draws_come_out_crossed():
    scenario = load_scenario("swap_hidden")
    drawn = [concrete(scenario, seed)["outcome"] for seed in range(200)]
    assert 0.4 < drawn.count("crossed") / 200 < 0.6


def test_parallel_hands_keep_their_gap_and_move_as_one_at_the_declared_speed(seeds):
    for seed in seeds:
        values = concrete(load_scenario("parallel"), seed)
        played = performance("parallel", seed)
        together, script = cues(played)["parallel"], played.script
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
        part = cues(played)["part"]
        assert np.linalg.norm(np.diff(palms(script, [part.to_s])[0], axis=0)) > 0.3
