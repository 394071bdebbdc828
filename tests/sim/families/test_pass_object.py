"""An object passed from hand to hand."""

from __future__ import annotations

import numpy as np
import pytest
from performances import HANDS, cue, drawn, gap_m, performance

SEEDS = range(4)


def test_a_thing_passes_from_one_hand_to_both_to_the_other(seeds):
    for seed in seeds:
        values = drawn("pass_object", seed)
        played = performance("pass_object", seed)
        script = played.script
        giver = HANDS.index(values["giver"])
        both = cue(played, "held_by:both")
        assert both.to_s - both.from_s == pytest.approx(values["both_hold"])
        first, last = (cue(played, f"held_by:{HANDS[side]}") for side in (giver, 1 - giver))
        assert first.to_s == both.from_s
        assert both.to_s == last.from_s
        assert [(h.side, h.from_s, h.to_s) for h in script.plan.holds] == [
            (giver, first.from_s, both.to_s),
            (1 - giver, both.to_s, last.to_s),
        ]
        for t in np.linspace(both.from_s, both.to_s - 1e-6, 4).tolist():
            pose = script.pose(t)
            axis = pose.objects["thing"].position_m[:2]
            for hand in pose.hands:
                assert np.linalg.norm(hand.position_m[:2] - axis) < 0.105
            assert gap_m(script, t) >= -0.005
            assert "held_by:both" in script.events(t)


def test_a_passed_thing_never_jumps_and_ends_upright_on_the_takers_side(seeds):
    for seed in seeds:
        script = performance("pass_object", seed).script
        outward = {"right": 1, "left": -1}[drawn("pass_object", seed)["giver"]]
        holds = script.plan.holds
        times = [t for h in holds for t in (h.from_s, h.to_s)] + np.arange(2, 10, 0.2).tolist()
        for t in times:
            before, after = (script.pose(t + k * 5e-4).objects["thing"] for k in (-1, 1))
            assert np.linalg.norm(after.position_m - before.position_m) < 2e-3
        top = script.scene.room.table_height_m
        low = min(script.pose(t).objects["thing"].position_m[2] for t in times)
        assert low > top - 0.003
        end = script.pose(15.0).objects["thing"]
        assert end.position_m[2] == top
        assert end.position_m[1] * outward > 0.04
        assert end.rotation[2, 2] == pytest.approx(1.0)


@pytest.mark.parametrize("thing", ["cup", "box", "ball"])
def test_any_of_the_things_can_be_passed(thing):
    assert performance("pass_object", 2, thing=thing).redrawn == 0
