"""The five families, posed: lengths, limits, contact, speeds, objects, purity."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest

from scenarios.spec.draw import concrete, perform
from scenarios.spec.names import load_scenario
from sim.contact.contact import penetration
from sim.motion.posture import posture
from sim.motion.strokes import HandState
from sim.person.kinematics import MAX_WRIST_BEND_RAD
from sim.pose import Pose
from sim.vectors import norm

NAMES = ("bounce", "calm_table", "cross", "drink", "speed_ladder")
SEEDS = range(5)
DT_S = 0.1

every = pytest.mark.parametrize("name", NAMES)


@cache
def performance(name, seed):
    return perform(load_scenario(name), seed)


@cache
def bodies(name, seed):
    played = performance(name, seed)
    times = np.arange(0.0, played.frames / played.fps, DT_S)
    return times, [played.script.body(t) for t in times.tolist()]


def palms(name, seed):
    times, posed = bodies(name, seed)
    return times, np.array([[arm.palm_m for arm in body.arms] for body in posed])


def speeds(path, dt_s=DT_S):
    return np.linalg.norm(np.diff(path, axis=0), axis=-1) / dt_s


def cues(name, seed):
    return {cue.name: cue for cue in performance(name, seed).script.plan.cues}


def assert_same(a: Pose, b: Pose):
    for first, second in (
        (a.torso, b.torso),
        (a.head, b.head),
        *zip(a.upper_arms + a.forearms + a.hands, b.upper_arms + b.forearms + b.hands, strict=True),
        *((a.objects[name], b.objects[name]) for name in a.objects),
    ):
        np.testing.assert_array_equal(first.position_m, second.position_m)
        np.testing.assert_array_equal(first.rotation, second.rotation)
    np.testing.assert_array_equal(a.curls, b.curls)


@every
def test_nothing_is_in_anything_by_more_than_5_mm(name, seeds):
    for seed in seeds:
        script = performance(name, seed).script
        anatomy = script.scene.anatomy
        for body in bodies(name, seed)[1]:
            obstacles = script.obstacles(body.torso, body.head)
            left = penetration(anatomy, body.arms, body.curls, obstacles)
            assert left.worst_m <= 0.005


@every
def test_arms_are_as_long_as_the_person_s_and_reach_their_targets(name, seeds):
    for seed in seeds:
        anatomy = performance(name, seed).scene.anatomy
        for body in bodies(name, seed)[1]:
            for arm in body.arms:
                assert norm(arm.elbow_m - arm.shoulder_m) == pytest.approx(anatomy.upper_arm_m)
                assert norm(arm.wrist_m - arm.elbow_m) == pytest.approx(anatomy.forearm_m)
                assert norm(arm.palm_m - arm.wrist_m) == pytest.approx(anatomy.wrist_to_palm_m)
                assert arm.short_m < 0.002
                bend = math.acos(min(1.0, float(arm.forearm[:, 0] @ arm.hand[:, 0])))
                assert bend <= MAX_WRIST_BEND_RAD + math.radians(3.0)


@every
def test_the_first_second_shows_two_still_hands_apart_on_the_table(name, seeds):
    for seed in seeds:
        times, path = palms(name, seed)
        first = path[times <= 1.0]
        top = performance(name, seed).scene.room.table_height_m
        assert np.ptp(first, axis=0).max() < 1e-9
        assert (np.linalg.norm(first[:, 0] - first[:, 1], axis=1) >= 0.25).all()
        assert (first[..., 2] - top < 0.05).all()
        assert (first[:, 0, 1] < 0).all()
        assert (first[:, 1, 1] > 0).all()


def test_calm_table_stays_below_its_speed_with_hands_15_cm_apart(seeds):
    for seed in seeds:
        declared = concrete(load_scenario("calm_table"), seed)["speed"]
        _, path = palms("calm_table", seed)
        # Tremor (3 mm below 1.6 Hz) adds a little to what the stroke does.
        assert 0.8 * declared <= speeds(path).max() <= declared + 0.02
        assert 0.1 <= speeds(path).max() <= 0.22
        assert np.linalg.norm(path[:, 0] - path[:, 1], axis=1).min() >= 0.20
        assert (speeds(path).max(axis=0) > 0.08).all()  # both hands work


@pytest.mark.parametrize("name", ["cross", "bounce"])
def test_crossing_hands_pass_the_middle_at_the_declared_speed(name, seeds):
    for seed in seeds:
        declared = concrete(load_scenario(name), seed)["speed"]
        played = performance(name, seed)
        event = cues("bounce", seed)["bounce"]
        times = np.arange(event.from_s - 0.4, event.from_s, 0.01).tolist()
        path = np.array([[a.palm_m for a in played.script.body(t).arms] for t in times])
        # The approach is broken off near the middle of the stroke: most of the peak is reached.
        assert 0.6 * declared <= speeds(path, 0.01).max() <= 1.05 * declared + 0.02


def test_drink_reaches_at_the_declared_speed_and_takes_16_to_20_s(seeds):
    for seed in seeds:
        values = concrete(load_scenario("drink"), seed)
        _, path = palms("drink", seed)
        side = ("right", "left").index(values["hand"])
        assert speeds(path)[:, side].max() == pytest.approx(values["speed"], rel=0.08)
        assert speeds(path)[:, 1 - side].max() < 0.02
        played = performance("drink", seed)
        assert 16.0 <= played.frames / played.fps <= 20.0


def test_the_ladder_climbs_through_its_rungs():
    labels = [f"speed:{v:g}" for v in (0.1, 0.2, 0.3, 0.5, 0.7, 1, 1.5, 2, 3)]
    for seed in (0, 1):
        played = performance("speed_ladder", seed)
        side = ("right", "left").index(concrete(load_scenario("speed_ladder"), seed)["hand"])
        rungs = cues("speed_ladder", seed)
        assert list(rungs) == labels
        assert list(rungs.values())[-1].to_s <= played.frames / played.fps
        for label, rung in rungs.items():
            assert rung.to_s - rung.from_s >= 2.4
            speed = float(label.split(":")[1])
            dt_s = 0.02 / max(speed, 0.5)
            end_s = min(rung.to_s, rung.from_s + 4 * 1.875 * 0.35 / speed)
            times = np.arange(rung.from_s, end_s, dt_s).tolist()
            path = np.array([played.script.body(t).arms[side].palm_m for t in times])
            assert speeds(path, dt_s).max() == pytest.approx(speed, rel=0.06, abs=0.03)
            assert np.ptp(path[:, 1]) == pytest.approx(0.35, abs=0.02)
            assert label in played.script.events(rung.from_s)


def test_cross_changes_sides_and_holds_and_bounce_does_not(seeds):
    for seed in seeds:
        crossed = cues("cross", seed)["crossed"]
        assert crossed.to_s - crossed.from_s >= 0.5
        script = performance("cross", seed).script
        for t in np.linspace(crossed.from_s, crossed.to_s, 5).tolist():
            right, left = script.body(t).arms
            assert right.palm_m[1] > 0.08
            assert left.palm_m[1] < -0.08
        _, path = palms("bounce", seed)
        assert (path[:, 0, 1] < 0).all()
        assert (path[:, 1, 1] > 0).all()


def test_cross_keeps_its_declared_speed_all_the_way(seeds):
    for seed in seeds:
        declared = concrete(load_scenario("cross"), seed)["speed"]
        event, script = cues("cross", seed)["cross"], performance("cross", seed).script
        times = np.arange(event.from_s, event.to_s, 0.02).tolist()
        path = np.array([[a.palm_m for a in script.body(t).arms] for t in times])
        assert speeds(path, 0.02).max() == pytest.approx(declared, rel=0.1, abs=0.02)


def test_bounce_touches(seeds):
    for seed in seeds:
        script = performance("bounce", seed).script
        touch = cues("bounce", seed)["touch"]
        body = script.body(touch.from_s + 0.01)
        gap = penetration(
            script.scene.anatomy, body.arms, body.curls, script.obstacles(body.torso, body.head)
        )
        assert -0.012 <= gap.hands_m <= 0.005


def test_cross_and_bounce_are_one_scene_until_the_hands_merge(seeds):
    for seed in seeds:
        cross, bounce = performance("cross", seed), performance("bounce", seed)
        assert cross.scene == bounce.scene
        merge_s = cues("bounce", seed)["bounce"].from_s
        assert merge_s == pytest.approx(cues("cross", seed)["cross"].from_s, abs=1e-9)
        for t in np.append(np.arange(0.0, merge_s, 0.25), merge_s - 1e-6).tolist():
            assert_same(cross.script.pose(t), bounce.script.pose(t))
        later = merge_s + 0.5
        moved = cross.script.body(later).arms[0].palm_m - bounce.script.body(later).arms[0].palm_m
        assert norm(moved) > 0.01


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
        drink = cues("drink", seed)["drink"]
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


def test_in_calm_table_both_things_are_carried():
    held = {hold.name for hold in performance("calm_table", 0).script.plan.holds}
    assert held == {"can", "box"}


@every
def test_poses_are_pure_and_the_same_at_any_frame_rate(name):
    scenario = load_scenario(name)
    slow = perform(scenario, 3, {"fps": 2, "frames": 20})
    fast = perform(scenario, 3, {"fps": 30, "frames": 300})
    for t in (9.5, 0.0, 4.25, 2.125):
        once = slow.script.pose(t)
        assert_same(once, fast.script.pose(t))
        assert_same(once, slow.script.pose(t))
        assert once.time_s == t


@every
def test_motion_is_smooth_between_frames(name):
    times, path = palms(name, 0)
    fastest = speeds(path).max()
    script = performance(name, 0).script
    for t in times[::7].tolist():
        step = script.body(t + 1e-3).arms[0].palm_m - script.body(t).arms[0].palm_m
        assert norm(step) <= 1.6e-3 * fastest + 1e-6  # 1.6: the fastest moment is between samples


def test_the_torso_leans_where_an_arm_would_be_stretched():
    anatomy = performance("cross", 0).scene.anatomy
    near, far = (
        [
            HandState(np.array([x, y, 0.8]), np.array([1.0, 0, 0, 0]), np.zeros(5))
            for y in (-0.2, 0.2)
        ]
        for x in (0.35, 0.75)
    )
    upright, _ = posture(anatomy, (near[0], near[1]), np.zeros(3))
    leant, head = posture(anatomy, (far[0], near[1]), np.zeros(3))
    assert abs(upright.position_m[0]) < 0.002
    assert 0.05 < leant.position_m[0] < 0.17
    assert head.position_m[0] > leant.position_m[0]


def test_the_head_sways_within_its_amplitude(seeds):
    for seed in seeds:
        declared = concrete(load_scenario("speed_ladder"), seed)["head_sway"]
        times, posed = bodies("speed_ladder", seed)
        heads = np.array([body.head.position_m for body in posed])[times < 1.0]
        assert np.linalg.norm(heads - heads[0], axis=1).max() <= 2 * declared


def test_speed_of_posing(benchmark):
    """Meant to stay below 2 ms on an idle core; reported with --benchmark-enable, never judged."""
    script = performance("bounce", 0).script
    assert benchmark(script.pose, cues("bounce", 0)["touch"].from_s).time_s > 0


@every
def test_speed_of_building(benchmark, name):
    """Meant to stay below 0.5 s on an idle core; reported with --benchmark-enable, never judged."""
    assert benchmark(perform, load_scenario(name), 0).frames > 0


def test_hands_that_brush_past_each_other_still_move_smoothly():
    """A gap so small that contact projection works in the middle of the stroke."""
    played = perform(load_scenario("cross"), 2, {"depth_gap": 0.055, "speed": 0.3, "bow": 0.0})
    event = next(cue for cue in played.script.plan.cues if cue.name == "cross")
    times = np.arange(event.from_s, event.to_s, 0.02).tolist()
    path = np.array([[a.palm_m for a in played.script.body(t).arms] for t in times])
    assert speeds(path, 0.02).max() < 0.9  # no jump: 0.3 m/s, and the way round the other
