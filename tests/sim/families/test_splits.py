"""All and objects: three targets in one blob, a hand in two, and skin that is no target's."""

from __future__ import annotations

from functools import cache

import cv2
import numpy as np
import pytest

from pjpdaf.detector.parameters import DetectorParameters
from pjpdaf.detector.skin import skin_mask, to_hsv
from pjpdaf.targets import HEAD, LEFT_HAND, RIGHT_HAND
from scenarios.spec.draw import concrete, perform
from scenarios.spec.names import load_scenario
from sim.camera.render import StereoRenderer
from sim.labels import view_truth
from sim.motion.measure import fault_of
from sim.scene.world import build
from sim.vectors import norm

NAMES = ("both_hands_to_head", "object_splits_hand", "skin_coloured_object", "bare_forearm")
SEEDS = range(200, 203)
HANDS = ("right", "left")

every = pytest.mark.parametrize("name", NAMES)


@cache
def performance(name, seed, **overrides):
    return perform(load_scenario(name), seed, overrides)


def value(name, seed, parameter):
    return concrete(load_scenario(name), seed)[parameter]


def cue(played, name):
    (found,) = (cue for cue in played.script.plan.cues if cue.name == name)
    return found


def renders(played, times, colour=False):
    """(views, truths of the views, world) at each of the times."""
    found = []
    with StereoRenderer(build(played.scene)) as renderer:
        for t_s in times:
            renderer.world.place(played.script.pose(t_s))
            views = renderer.render(colour=colour)
            found.append((views, [view_truth(view) for view in views], renderer.world))
    return found


def parts_px(mask):
    """Sizes of the connected parts of a mask, the largest first."""
    _, _, stats, _ = cv2.connectedComponentsWithStats(mask.astype(np.uint8), connectivity=8)
    return sorted(stats[1:, cv2.CC_STAT_AREA].tolist(), reverse=True)


def pixels_of(view, world, word):
    """Mask of the geoms whose names contain a word."""
    named = [g for g in range(world.model.ngeom) if word in world.model.geom(g).name]
    assert named
    return np.isin(view.geoms, named)


def skin(picture):
    found = DetectorParameters().skin
    return skin_mask(to_hsv(picture), found) > 0


@every
@pytest.mark.parametrize("count", [3, pytest.param(10, marks=pytest.mark.long)])
def test_nearly_every_seed_is_posable_at_once(name, count):
    scenario = load_scenario(name)
    assert sum(perform(scenario, seed).redrawn > 0 for seed in range(200, 200 + count)) <= 1


@every
def test_the_motion_is_possible_between_frames_as_well(name):
    played = performance(name, SEEDS[0])
    times = np.arange(0.0, played.frames / played.fps, 0.1) + 0.031
    assert fault_of(played.script, times.tolist()) is None


@every
def test_hands_start_still_and_apart_and_move_without_jumps(name, seeds):
    for seed in seeds:
        played = performance(name, seed)
        first = [[a.palm_m for a in played.script.body(t).arms] for t in (0.0, 0.5, 1.0)]
        assert np.ptp(first, axis=0).max() < 1e-9
        assert norm(first[0][0] - first[0][1]) >= 0.25
        speed = value(name, seed, "speed")
        for side in (0, 1):
            told = played.script.plan.hands[side]
            fine = np.array([told.at(t).position_m for t in np.arange(1.0, 9.0, 2e-3).tolist()])
            assert np.linalg.norm(np.diff(fine, axis=0), axis=1).max() <= 2e-3 * 1.01 * speed
            assert np.abs(np.diff(fine, 2, axis=0)).max() < 2e-3**2 * 30.0  # m/s2
            for t in np.arange(0.5, played.frames / played.fps, 0.37).tolist():
                now, then = (played.script.body(at).arms[side].palm_m for at in (t, t + 1e-3))
                # A hand that meets the head is held off, and then moves differently.
                assert norm(then - now) <= 1.6e-3 * speed + 2e-4


@every
def test_the_motion_does_not_depend_on_the_frame_rate(name):
    slow = performance(name, SEEDS[0], fps=2, frames=24).script
    fast = performance(name, SEEDS[0], fps=24, frames=288).script
    for t in (0.0, 4.25, 2.125, 7.5):
        one, other = slow.pose(t), fast.pose(t)
        for a, b in (
            *zip(one.hands, other.hands, strict=True),
            *((one.objects[k], other.objects[k]) for k in one.objects),
        ):
            np.testing.assert_array_equal(a.position_m, b.position_m)
            np.testing.assert_array_equal(a.rotation, b.rotation)


@pytest.mark.parametrize("where", ["cheeks", "forehead", "face"])
def test_head_and_both_hands_are_one_blob_in_both_views(where):
    for seed in SEEDS[:1]:
        played = performance("both_hands_to_head", seed, where=where)
        on = cue(played, "on_head")
        assert 0.5 <= on.to_s - on.from_s <= 5.0
        times = [0.0, *np.linspace(on.from_s + 0.02, on.to_s - 0.02, 3).tolist()]
        (_, before, _), *during = renders(played, times)
        assert not any(view.merged.any() for view in before)
        for _, truths, _ in during:
            for view in truths:
                assert view.merged[HEAD, RIGHT_HAND]
                assert view.merged[HEAD, LEFT_HAND]
                assert view.visible_fractions.min() > 0.15


@pytest.mark.parametrize("where", ["cheeks", "forehead", "face"])
def test_hands_on_the_head_are_planned_so_that_nothing_has_to_push_them(where, seeds):
    for seed in seeds:
        played = performance("both_hands_to_head", seed, where=where)
        plan, script = played.script.plan, played.script
        for t in np.arange(cue(played, "to_head").from_s, cue(played, "back").to_s, 0.1).tolist():
            sway = plan.sway.at(t)
            for arm, hand, tremor in zip(script.body(t).arms, plan.hands, plan.tremor, strict=True):
                told = hand.at(t)
                goal = told.position_m + told.air * tremor.at(t) + told.with_head * sway
                assert norm(arm.palm_m - goal) < 0.006  # of 40 where they would be in each other


def test_the_hands_lie_on_the_head_and_stay_with_it(seeds):
    for seed in seeds:
        played = performance("both_hands_to_head", seed)
        on = cue(played, "on_head")
        for t in np.linspace(on.from_s, on.to_s, 4).tolist():
            body, anatomy = played.script.body(t), played.scene.anatomy
            half = 0.5 * np.array(
                [anatomy.head_depth_m, anatomy.head_breadth_m, anatomy.head_height_m]
            )
            for arm in body.arms:
                inside = body.head.rotation.T @ (arm.palm_m - body.head.position_m)
                # The palm's centre is half a hand's thickness, 17 mm, off the skin.
                outside = norm(inside) - norm(inside) / norm(inside / half)
                assert outside < 0.06


def test_a_rod_splits_the_hand_in_two_in_both_views(seed):
    played = performance("object_splits_hand", seed, what="rod")
    hand = 1 + HANDS.index(value("object_splits_hand", seed, "hand"))
    on = cue(played, "covered")
    before, during = renders(played, [0.0, 0.5 * (on.from_s + on.to_s)])
    for view in before[0]:
        assert sum(size > 20 for size in parts_px(view.targets == hand)) == 1
    for view in during[0]:
        first, second, *_ = parts_px(view.targets == hand)
        assert second >= 300
        assert first < 0.75 * (first + second)


def test_a_board_leaves_300_to_700_px_of_the_hand(seed):
    played = performance("object_splits_hand", seed, what="board")
    hand = 1 + HANDS.index(value("object_splits_hand", seed, "hand"))
    on = cue(played, "covered")
    before, during = renders(played, [0.0, 0.5 * (on.from_s + on.to_s)])
    assert min(view.visible_px[hand] for view in before[1]) > 1500
    for view in during[1]:
        assert 300 <= view.visible_px[hand] <= 700


def test_the_tool_stays_in_its_hand_above_the_table_and_the_other_hand(seeds):
    for seed in seeds:
        played = performance("object_splits_hand", seed)
        (hold,) = played.script.plan.holds
        top = played.scene.room.table_height_m
        grips = []
        for t in np.arange(0.0, played.frames / played.fps, 0.5).tolist():
            pose = played.script.pose(t)
            hand, tool = pose.hands[hold.side], pose.objects["tool"]
            grips.append(hand.rotation.T @ (tool.position_m - hand.position_m))
            assert tool.position_m[2] > top
            assert tool.rotation[2, 2] > 0.98
        assert np.ptp(grips, axis=0).max() < 1e-9
        assert played.script.plan.hands[1 - hold.side].at(9.0).position_m[2] < top + 0.06


def test_the_block_has_the_colour_of_skin_and_joins_the_hand_that_carries_it(seeds):
    shares = []
    for seed in seeds:
        played = performance("skin_coloured_object", seed)
        carried = cue(played, "carried")
        ((views, _, world),) = renders(played, [0.5 * (carried.from_s + carried.to_s)], colour=True)
        hand = 1 + HANDS.index(value("skin_coloured_object", seed, "hand"))
        for view in views:
            block, mine = pixels_of(view, world, "object:block"), view.targets == hand
            found = skin(view.colour)
            shares.append([found[block].mean(), found[mine].mean(), block.sum() / mine.sum()])
            assert len([s for s in parts_px(block | mine) if s > 50]) == 1
    block, mine, size = np.transpose(shares)
    assert block.min() > 0.8
    assert mine.min() > 0.8
    assert size.min() > 0.4


def test_the_block_goes_with_the_hand_and_is_put_down_elsewhere(seeds):
    for seed in seeds:
        played = performance("skin_coloured_object", seed)
        (hold,) = played.script.plan.holds
        top = played.scene.room.table_height_m
        first, last = (played.script.pose(t).objects["block"] for t in (0.0, hold.to_s + 0.01))
        assert first.position_m[2] == last.position_m[2] == top
        assert 0.02 < norm(first.position_m - last.position_m) < 0.1
        middle = np.linspace(hold.from_s, hold.to_s, 12).tolist()
        assert max(played.script.pose(t).objects["block"].position_m[2] for t in middle) > top + 0.1


def test_bare_forearms_are_skin_that_belongs_to_no_target(seeds):
    for seed in seeds:
        played = performance("bare_forearm", seed)
        assert played.scene.appearance.sleeves in ("rolled", "short")
        stand = [c for c in played.script.plan.cues if c.name.startswith("stand:")]
        end_s = played.frames / played.fps
        times = [c.to_s - 0.05 for c in stand if c.to_s < end_s][:2]
        for views, truths, world in renders(played, times, colour=True):
            for view, truth in zip(views, truths, strict=True):
                bare = pixels_of(view, world, "bare:forearm")
                assert (view.targets[bare] == -1).all()
                assert bare.sum() > 0.3 * truth.visible_px[1:].sum()
                assert skin(view.colour)[bare].mean() > 0.7


def test_bare_forearms_stand_lie_and_spread_in_both_hands(seeds):
    for seed in seeds:
        names = {c.name for c in performance("bare_forearm", seed).script.plan.cues}
        assert len(names) >= 4
        assert {name.partition(":")[2] for name in names} == set(HANDS)
