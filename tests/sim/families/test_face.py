"""Hand and head: touching the face, a phone at the ear, a hand behind the head."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from scenarios.spec.draw import concrete, perform
from scenarios.spec.names import load_scenario
from sim.contact.contact import hand_capsules
from sim.person.head import head_surface
from sim.sequence import Simulation

NAMES = ("touch_face", "phone_at_ear", "hand_behind_head")
SEEDS = range(200, 203)

every = pytest.mark.parametrize("name", NAMES)


@cache
def performance(name, seed, *overrides):
    return perform(load_scenario(name), seed, dict(overrides))


def values(name, seed, *overrides):
    redrawn = performance(name, seed, *overrides).redrawn
    return concrete(load_scenario(name), seed, dict(overrides), redrawn)


def cues(played, name):
    return [cue for cue in played.script.plan.cues if cue.name.split(":")[0] == name]


def shown(played, times_s):
    """Truth at these times."""
    with Simulation(replace(played, fps=100.0, frames=100_000)) as simulation:
        return [simulation.render(round(100 * t)).truth for t in times_s]


def air_to_face(played, side, t_s):
    """Least distance [m] from the skin of a hand to the drawn head, negative inside a finger."""
    anatomy, pose = played.scene.anatomy, played.script.pose(t_s)
    hand = pose.hands[side]
    bars = hand_capsules(anatomy, side, pose.curls[side]).placed(hand.position_m, hand.rotation)
    face = head_surface(anatomy).vertices_m @ pose.head.rotation.T + pose.head.position_m
    along = bars.ends_m - bars.starts_m
    offset = face[:, None] - bars.starts_m
    share = np.clip((offset * along).sum(-1) / (along * along).sum(-1), 0.0, 1.0)
    away = np.linalg.norm(offset - share[..., None] * along, axis=-1) - bars.radii_m
    return float(away.min())


@every
def test_nominal_draws_can_be_posed(name, seeds):
    assert sum(performance(name, seed).redrawn for seed in seeds) <= 1


@every
def test_the_first_second_is_still_with_hands_apart(name, seeds):
    for seed in seeds:
        script = performance(name, seed).script
        first, last = script.body(0.0), script.body(1.05)
        for one, other in zip(first.arms, last.arms, strict=True):
            np.testing.assert_allclose(one.palm_m, other.palm_m, atol=1e-9)
        assert np.linalg.norm(first.arms[0].palm_m - first.arms[1].palm_m) > 0.25


@every
def test_motion_is_smooth_in_continuous_time(name, seeds):
    h = 1e-3
    for seed in seeds:
        played = performance(name, seed)
        for hand in played.script.plan.hands:
            times = np.arange(1.0, played.frames / played.fps, h * 17).tolist()
            places = np.array([[hand.at(t + k * h).position_m for k in range(3)] for t in times])
            jumps = np.linalg.norm(np.diff(places, n=2, axis=1), axis=-1) / h
            # 40 mm/s in 1 ms: four g, which a hand can do; a jump would be a speed.
            assert jumps.max() < 0.04
        for t in np.arange(1.2, 20.0, 0.93).tolist():
            now, soon = played.script.body(t), played.script.body(t + h)
            for one, other in zip(now.arms, soon.arms, strict=True):
                # Contact projection stops at 0.4 mm of overlap, and so leaves that to and fro.
                assert np.linalg.norm(other.palm_m - one.palm_m) < 1.5e-3


@every
def test_it_is_the_same_motion_at_any_frame_rate(name):
    slow = performance(name, 200, ("fps", 2), ("frames", 24)).script
    fast = performance(name, 200, ("fps", 30), ("frames", 360)).script
    for t in (9.3, 2.0, 11.9):
        for one, other in zip(slow.body(t).arms, fast.body(t).arms, strict=True):
            np.testing.assert_array_equal(one.palm_m, other.palm_m)
            np.testing.assert_array_equal(one.elbow_m, other.elbow_m)


@every
def test_all_is_over_before_the_sequence_ends(name, seeds):
    for seed in seeds:
        played = performance(name, seed)
        assert played.script.plan.cues[-1].to_s < played.frames / played.fps


@every
def test_the_hand_moves_at_its_declared_speed(name, seeds):
    for seed in seeds:
        played, drawn = performance(name, seed), values(name, seed)
        times = np.arange(1.0, played.frames / played.fps, 0.02).tolist()
        fastest = max(
            np.linalg.norm(np.diff([h.at(t).position_m for t in times], axis=0), axis=1).max()
            for h in played.script.plan.hands
        )
        assert 0.75 * drawn["speed"] <= fastest / 0.02 <= 1.02 * drawn["speed"]


@pytest.mark.parametrize("place", ["cheek", "chin", "mouth", "forehead"])
def test_fingers_lie_on_the_face(place, seeds):
    for seed in seeds:
        played = performance("touch_face", seed, ("place", place))
        for touch in cues(played, "on_face"):
            assert touch.name == f"on_face:{place}"
            side = _side_that_moved(played, touch.from_s)
            air = [air_to_face(played, side, t) for t in (touch.from_s + 0.02, touch.to_s - 0.02)]
            # The head that fingers must keep out of is an ellipsoid; the drawn one lies up to
            # a centimetre within it at lips and brow, and its nose and chin stand out.
            assert min(air) > -0.008
            assert max(air) < 0.012


def _side_that_moved(played, t_s):
    hands = played.script.body(t_s).arms
    return int(hands[1].palm_m[2] > hands[0].palm_m[2])


def test_touches_are_as_many_and_as_long_as_declared(seeds):
    for seed in seeds:
        played, drawn = performance("touch_face", seed), values("touch_face", seed)
        touches = cues(played, "on_face")
        assert len(touches) == round(drawn["touches"]) >= 3
        for touch in touches:
            assert 0.5 <= touch.to_s - touch.from_s <= 3.0
        assert len({touch.name for touch in touches}) >= 3  # all places by turns


def test_a_touch_is_one_blob_with_the_face_in_both_views():
    played = performance("touch_face", 200)
    touch = cues(played, "on_face")[0]
    side = _side_that_moved(played, touch.from_s)
    (truth,) = shown(played, [0.5 * (touch.from_s + touch.to_s)])
    for view in truth.views:
        assert view.merged[0, 1 + side]


def test_the_phone_is_held_at_the_ear_for_3_to_15_s(seeds):
    for seed in seeds:
        played, drawn = performance("phone_at_ear", seed), values("phone_at_ear", seed)
        (held,) = cues(played, "at_ear")
        assert held.to_s - held.from_s == pytest.approx(drawn["hold"])
        assert 3.0 <= drawn["hold"] <= 15.0
        anatomy, side = played.scene.anatomy, ("right", "left").index(drawn["hand"])
        for t in np.linspace(held.from_s, held.to_s, 5).tolist():
            pose = played.script.pose(t)
            ear = np.array([0.0, (-0.5, 0.5)[side] * anatomy.head_breadth_m, 0.0])
            ear = pose.head.position_m + pose.head.rotation @ ear
            phone = pose.objects["phone"]
            local = phone.rotation.T @ (ear - phone.position_m)
            beyond = np.abs(local - [0.0, 0.0, 0.0045]) - [0.036, 0.074, 0.0045]
            assert np.linalg.norm(np.maximum(beyond, 0.0)) < 0.03
            assert abs(phone.rotation[1, 2]) > 0.7  # its face towards the head


def test_the_elbow_of_the_phone_s_arm_is_off_the_table_and_below_the_shoulder(seeds):
    for seed in seeds:
        played, drawn = performance("phone_at_ear", seed), values("phone_at_ear", seed)
        (held,) = cues(played, "at_ear")
        arm = played.script.body(held.from_s + 0.5).arms[("right", "left").index(drawn["hand"])]
        assert arm.elbow_m[2] > played.scene.room.table_height_m + 0.03
        assert arm.elbow_m[2] < arm.shoulder_m[2]


def test_the_phone_lies_again_where_it_is_put(seeds):
    for seed in seeds:
        played, drawn = performance("phone_at_ear", seed), values("phone_at_ear", seed)
        (hold,) = played.script.plan.holds
        first = played.script.pose(0.0).objects["phone"]
        last = played.script.pose(hold.to_s + 1.0).objects["phone"]
        outward = (-1.0, 1.0)[hold.side]
        moved = [drawn["put_dx"], outward * drawn["put_dy"], 0.0]
        np.testing.assert_allclose(last.position_m - first.position_m, moved, atol=3e-3)
        before = played.script.pose(hold.to_s - 1e-6).objects["phone"]
        assert np.linalg.norm(before.position_m - last.position_m) < 3e-3


def test_the_hand_behind_the_head_is_hidden_for_1_to_6_s(seed):
    played = performance("hand_behind_head", seed)
    drawn = values("hand_behind_head", seed)
    side = ("right", "left").index(drawn["hand"])
    gone = cues(played, "behind")
    assert len(gone) == round(drawn["times"])
    assert 1.0 <= gone[0].to_s - gone[0].from_s <= 6.0
    for truth in shown(played, [gone[0].from_s + 0.05, gone[0].to_s - 0.05]):
        for view in truth.views:
            assert view.visible_fractions[1 + side] < 0.1


@pytest.mark.parametrize("out", ["same", "other"])
def test_the_hand_comes_out_on_the_side_asked_for(out):
    played = performance("hand_behind_head", 201, ("out", out))
    side = ("right", "left").index(values("hand_behind_head", 201, ("out", out))["hand"])
    outward = (-1.0, 1.0)[side]
    leaving = cues(played, "out")[0]
    times = np.arange(leaving.from_s, leaving.to_s, 0.1).tolist()
    posed = [played.script.body(t) for t in times]
    across = np.array([outward * b.arms[side].palm_m[1] for b in posed])
    up = np.array([b.arms[side].palm_m[2] - b.head.position_m[2] for b in posed])
    if out == "same":
        assert across.min() > -0.05
        assert up.max() < 0.15
        return
    assert across.min() < -0.05  # beyond the head's middle, on its other side
    assert up.max() > 0.14  # and back over the crown
    peek = times[int(across.argmin())] + 0.1
    (truth,) = shown(played, [peek])
    for view in truth.views:
        assert view.visible_fractions[1 + side] > 0.3
        centre = view.centroids_px
        # The person's right is the picture's left.
        assert outward * (centre[1 + side, 0] - centre[0, 0]) < 0
