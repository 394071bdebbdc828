"""Both hands laid on the head."""

from __future__ import annotations

import numpy as np
import pytest
from performances import cue, performance, truths

from pjpdaf.targets import HEAD, LEFT_HAND, RIGHT_HAND
from sim.vectors import norm

SEEDS = range(200, 203)


@pytest.mark.long
@pytest.mark.parametrize("where", ["cheeks", "forehead", "face"])
def test_head_and_both_hands_are_one_blob_in_both_views(where):
    for seed in SEEDS[:1]:
        played = performance("both_hands_to_head", seed, where=where)
        on = cue(played, "on_head")
        assert 0.5 <= on.to_s - on.from_s <= 5.0
        times = [0.0, *np.linspace(on.from_s + 0.02, on.to_s - 0.02, 3).tolist()]
        before, *during = truths(played, times)
        assert not any(view.merged.any() for view in before)
        for views in during:
            for view in views:
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
