"""Retargeting: palms where they were recorded, as far as this body and its table let them."""

from __future__ import annotations

import math
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import scenarios
from sim.anatomy import Anatomy
from sim.clips.clip_files import load_clip
from sim.clips.clips import JOINTS, Clip, clip_of, mirrored
from sim.clips.retarget import retarget
from sim.families.recorded import ClipClock
from sim.motion.posture import posture
from sim.person.kinematics import shoulders
from sim.pose import SIDES
from sim.specs import SceneSpec

STORY = Path(scenarios.__file__).parent / "catalog" / "clips" / "story.csv"
HANDS_ONLY = ("head", "left_hand", "right_hand")
BODIES = (1.55, 1.72, 1.88)


@cache
def story():
    return load_clip(STORY)


def scene(stature_m=1.72):
    return SceneSpec(anatomy=Anatomy.of(stature_m))


def wished(body, clip, side):
    return body.fit.placed(clip.path(f"{SIDES[side]}_hand"))


def only(clip, joints):
    xyz = np.stack([clip.path(joint) for joint in joints], axis=1)
    return Clip(clip.name, clip.times_s, joints, xyz)


def still(palm, n=60):
    """A clip of two hands that sway a little about a palm's place and its mirror image."""
    t = np.arange(n) / 30
    sway = 0.01 * np.sin(2 * np.pi * 0.5 * t)[:, None] * np.ones(3)
    palm = np.array(palm)
    places = [np.array([0.05, 0.0, 0.22]) + 0 * sway, palm + sway, palm * [1, -1, 1] - sway]
    return clip_of("still", t, HANDS_ONLY, np.stack(places, axis=1))


@pytest.mark.parametrize("stature", BODIES)
def test_the_clip_is_scaled_by_the_length_of_the_arm(stature):
    body = retarget(story(), scene(stature), 0.5)
    # The clip was made with the average body.
    assert body.fit.scale == pytest.approx(stature / 1.72, rel=0.01)
    assert "as recorded" in body.fit.description


def test_without_elbows_the_arm_is_taken_from_the_reach_and_that_is_said():
    clip = only(story(), HANDS_ONLY)
    assert "no elbows: arm taken to be the average" in retarget(clip, scene(), 0.5).fit.description
    far = clip_of("far", clip.times_s, clip.joints, clip.xyz * 1.4)
    body = retarget(far, scene(), 0.5)
    assert "the furthest reach" in body.fit.description
    anatomy = scene().anatomy
    arm = anatomy.upper_arm_m + anatomy.forearm_m + anatomy.wrist_to_palm_m
    reach = far.path("left_hand") - [0.0, 0.185, 0.0]
    assert np.quantile(np.linalg.norm(reach, axis=1), 0.9) * body.fit.scale < arm


@pytest.mark.parametrize("stature", BODIES)
def test_what_lies_within_limits_is_played_where_and_as_fast_as_it_was_recorded(stature):
    clip = story()
    body = retarget(clip, scene(stature), 0.5)
    assert body.changed < 0.1
    for side in (0, 1):
        played = np.array([body.hand(side, t).position_m for t in clip.times_s.tolist()])
        off = np.linalg.norm(played - wished(body, clip, side), axis=1)
        assert np.quantile(off, 0.7) < 0.003
        speeds = np.linalg.norm(np.diff(played, axis=0), axis=1) * 30
        recorded = body.fit.scale * clip.speeds(f"{SIDES[side]}_hand")
        for share in (0.5, 0.9, 0.99):
            ours, theirs = np.quantile(speeds, share), np.quantile(recorded, share)
            assert ours == pytest.approx(theirs, rel=0.03)


@pytest.mark.parametrize("place", [(0.1, 0.3, -0.6), (0.3, 0.2, -0.45), (0.0, 0.4, -0.5)])
def test_hands_below_the_table_or_at_the_side_are_laid_on_it(place):
    room = scene()
    body = retarget(still(place), room, 0.5)
    top = room.room.table_height_m
    for side in (0, 1):
        state = body.hand(side, 1.0)
        assert 0.02 < state.position_m[2] - top < 0.12
        assert state.position_m[0] > room.room.table_near_x_m
        assert state.rotation[2, 0] > -0.2  # fingers do not point into the table


def test_a_motion_below_the_table_is_lifted_over_it_and_keeps_its_form():
    clip = story()
    low = clip_of("low", clip.times_s, clip.joints, clip.xyz - [0.0, 0.0, 0.2])
    body, usual = retarget(low, scene(), 0.5), retarget(clip, scene(), 0.5)
    lift = body.fit.offset_m[2] - usual.fit.offset_m[2]
    assert 0.05 < lift < 0.2
    for side in (0, 1):
        times = clip.times_s.tolist()
        ours, theirs = (
            np.array([b.hand(side, t).position_m for t in times]) for b in (body, usual)
        )
        across = np.abs(ours[:, 1] - theirs[:, 1])
        assert np.quantile(across, 0.9) < 0.005


def test_a_motion_that_is_high_is_not_lifted_out_of_sight():
    clip = story()
    tall = clip.xyz * [1.0, 1.0, 2.4]  # from below the table to above the head
    body = retarget(clip_of("tall", clip.times_s, clip.joints, tall), scene(), 0.5)
    assert "lifted by 0.000 m" in body.fit.description


def test_hands_out_of_reach_are_brought_into_it_smoothly():
    room = scene()
    anatomy = room.anatomy
    arm = anatomy.upper_arm_m + anatomy.forearm_m + anatomy.wrist_to_palm_m
    t = np.arange(120) / 30
    out = 0.3 + 0.5 * t / t[-1]  # until 0.8 m ahead
    sides = [np.column_stack([out, 0 * t + y, 0 * t]) for y in (0.2, -0.2)]
    clip = clip_of("far", t, HANDS_ONLY[1:], np.stack(sides, axis=1))
    body = retarget(clip, room, 0.5, scale=1.25)
    played = np.array([body.palms(at)[0] for at in np.arange(0.0, 3.9, 0.01)])
    speeds = np.linalg.norm(np.diff(played, axis=0), axis=1) / 0.01
    assert np.abs(np.diff(speeds)).max() < 0.02
    assert (np.linalg.norm(played - [0, -0.19, anatomy.mid_shoulder_height_m], axis=1) < arm).all()


@pytest.mark.parametrize("side", [0, 1])
def test_recorded_elbows_swivel_the_arm(side):
    clip = story()
    raised = clip.xyz.copy()
    elbow = clip.joints.index(f"{SIDES[side]}_elbow")
    raised[:, elbow] += [0.0, (-0.1, 0.1)[side], 0.15]
    lifted = clip_of("elbows", clip.times_s, clip.joints, raised)
    plain, high = (retarget(c, scene(), 0.5) for c in (clip, lifted))
    mine = [b.hand(side, 6.0).swivel_rad for b in (plain, high)]
    other = [b.hand(1 - side, 6.0).swivel_rad for b in (plain, high)]
    assert mine[1] > mine[0] + 0.3
    assert other[0] == pytest.approx(other[1], abs=0.02)
    assert abs(plain.hand(side, 2.0).swivel_rad) < 0.35  # made with a habit of 0.5


def test_without_elbows_arms_swivel_as_the_person_does():
    body = retarget(only(story(), HANDS_ONLY), scene(), 0.5)
    assert body.hand(0, 3.0).swivel_rad == 0.0


@pytest.mark.parametrize("joints", [JOINTS, HANDS_ONLY])
def test_hands_point_along_the_forearm_and_turn_smoothly(joints):
    clip = only(story(), joints)
    body = retarget(clip, scene(), 0.5)
    for side in (0, 1):
        forearm = story().path(f"{SIDES[side]}_wrist") - story().path(f"{SIDES[side]}_elbow")
        before = None
        for k, t in enumerate(clip.times_s.tolist()):
            rotation = body.hand(side, t).rotation
            along = forearm[k] / np.linalg.norm(forearm[k])
            assert math.degrees(math.acos(min(1.0, float(rotation[:, 0] @ along)))) < 60
            assert rotation[2, 2] > -0.2  # palms face down or each other, not the ceiling
            if before is not None:
                cosine = 0.5 * (np.trace(before.T @ rotation) - 1)
                assert math.degrees(math.acos(min(1.0, cosine))) < 20  # per frame
            before = rotation


def test_torso_leans_and_turns_with_recorded_shoulders_and_the_head_follows():
    clip = story()
    t = clip.times_s
    lean, turn = 0.1 * np.sin(2 * np.pi * 0.1 * t), 0.15 * np.sin(2 * np.pi * 0.07 * t)
    spine = 0.345 * 1.72
    xyz = clip.xyz.copy()
    for joint in ("head", "left_shoulder", "right_shoulder"):
        k = clip.joints.index(joint)
        x, y = xyz[:, k, 0].copy(), xyz[:, k, 1].copy()
        xyz[:, k, 0] = np.cos(turn) * x - np.sin(turn) * y + spine * np.sin(lean)
        xyz[:, k, 1] = np.sin(turn) * x + np.cos(turn) * y
    body = retarget(clip_of("lean", t, clip.joints, xyz), scene(), 0.5)
    for at, k in ((2.5, 75), (7.4, 222), (10.0, 300)):
        carriage = body.carriage(at)
        assert carriage.forward_rad == pytest.approx(lean[k] - np.median(lean), abs=0.04)
        assert carriage.turn_rad == pytest.approx(turn[k] - np.median(turn), abs=0.04)
        states = (body.hand(0, at), body.hand(1, at))
        torso, _ = posture(scene().anatomy, states, np.zeros(3), carriage)
        right, left = shoulders(scene().anatomy, torso.position_m, torso.rotation)
        ours = np.arctan2(-(left - right)[0], (left - right)[1])
        assert ours == pytest.approx(turn[k] - np.median(turn), abs=0.06)


def test_without_shoulders_the_torso_goes_with_the_head():
    clip = only(story(), HANDS_ONLY)
    xyz = clip.xyz.copy()
    xyz[:, 0, 0] += 0.06 * np.sin(2 * np.pi * 0.2 * clip.times_s)
    body = retarget(clip_of("nod", clip.times_s, clip.joints, xyz), scene(), 0.5)
    forward = [body.carriage(t).forward_rad for t in clip.times_s.tolist()]
    assert 0.05 < max(forward) < 0.12
    hands = only(clip, HANDS_ONLY[1:])
    assert retarget(hands, scene(), 0.5).carriage(3.0).forward_rad == 0.0


def test_a_mirrored_clip_is_played_as_the_mirror_image():
    ours, theirs = retarget(story(), scene(), 0.5), retarget(mirrored(story()), scene(), 0.5)
    flip = np.array([1.0, -1.0, 1.0])
    for t in (0.0, 2.5, 5.9, 9.1):
        for side in (0, 1):
            a, b = ours.hand(side, t), theirs.hand(1 - side, t)
            np.testing.assert_allclose(a.position_m * flip, b.position_m, atol=1e-9)
            mirror = np.diag(flip)
            np.testing.assert_allclose(mirror @ a.rotation @ mirror, b.rotation, atol=1e-6)
            assert a.swivel_rad == pytest.approx(b.swivel_rad, abs=1e-9)


def test_finer_adjustment_scales_and_lifts():
    clip = story()
    body = retarget(clip, scene(), 0.5)
    big, high = retarget(clip, scene(), 0.5, scale=1.1), retarget(clip, scene(), 0.5, lift_m=0.1)
    assert big.fit.scale == pytest.approx(1.1 * body.fit.scale)
    assert high.fit.offset_m[2] == pytest.approx(body.fit.offset_m[2] + 0.1)


# --- the clip's time -----------------------------------------------------------------------------


@pytest.mark.parametrize("slow", [1.0, 2.5, 8.0])
@pytest.mark.parametrize("length", [0.15, 0.5, 12.0])
def test_the_clip_s_time_starts_and_ends_gently_and_runs_evenly_between(slow, length):
    clock = ClipClock(2.0, 1.0, 1.0 + length, slow)
    times = np.linspace(1.5, clock.over_s + 0.5, 4000)
    shown = np.array([clock.clip_s(t) for t in times.tolist()])
    assert shown[0] == 1.0
    assert shown[-1] == 1.0 + length
    rates = np.diff(shown) / np.diff(times) * slow
    assert rates.min() >= 0.0
    assert rates.max() <= 1.0 + 1e-6
    # No jump in speed: it takes ramp_s to get going.
    assert np.abs(np.diff(rates)).max() < 2.5 * (times[1] - times[0]) / clock.ramp_s
    if length == 12.0:
        middle = clock.when(7.0)
        assert clock.clip_s(middle) == pytest.approx(7.0)
        assert clock.over_s == pytest.approx(2.0 + slow * length + 0.4)
