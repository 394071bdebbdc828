"""A dark object laid across a hand."""

from __future__ import annotations

import numpy as np
from performances import HANDS, components_px, cue, drawn, end_s, performance, renders

SEEDS = range(200, 203)


def test_a_rod_splits_the_hand_in_two_in_both_views(seed):
    played = performance("object_splits_hand", seed, what="rod")
    hand = 1 + HANDS.index(drawn("object_splits_hand", seed)["hand"])
    on = cue(played, "covered")
    before, during = renders(played, [0.0, 0.5 * (on.from_s + on.to_s)])
    for view in before[0]:
        assert sum(size > 20 for size in components_px(view.targets == hand)) == 1
    for view in during[0]:
        first, second, *_ = components_px(view.targets == hand)
        assert second >= 300
        assert first < 0.75 * (first + second)


def test_a_board_leaves_300_to_700_px_of_the_hand(seed):
    played = performance("object_splits_hand", seed, what="board")
    hand = 1 + HANDS.index(drawn("object_splits_hand", seed)["hand"])
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
        for t in np.arange(0.0, end_s(played), 0.5).tolist():
            pose = played.script.pose(t)
            hand, tool = pose.hands[hold.side], pose.objects["tool"]
            grips.append(hand.rotation.T @ (tool.position_m - hand.position_m))
            assert tool.position_m[2] > top
            assert tool.rotation[2, 2] > 0.98
        assert np.ptp(grips, axis=0).max() < 1e-9
        assert played.script.plan.hands[1 - hold.side].at(9.0).position_m[2] < top + 0.06
