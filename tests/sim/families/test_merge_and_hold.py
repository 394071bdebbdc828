"""One hand clasped in the other."""

from __future__ import annotations

import numpy as np
import pytest
from performances import HANDS, cue, drawn, gap_m, halved, performance, truths

from scenarios.spec.names import load_scenario

SEEDS = range(4)


def test_clasped_hands_touch_for_the_declared_time_and_are_apart_before_and_after(seeds):
    for seed in seeds:
        values = drawn("merge_and_hold", seed)
        played = performance("merge_and_hold", seed)
        script, held = played.script, cue(played, "clasp")
        assert held.to_s - held.from_s == pytest.approx(values["hold"], abs=1e-6)
        for t in np.linspace(held.from_s, held.to_s, 7).tolist():
            assert -0.005 <= gap_m(script, t) <= 0.002
        outer = HANDS.index(values["outer"])
        curls = script.body(held.from_s).curls
        assert (curls[outer, 1:4] > 0.15).all()  # round the fist, which is closed further
        assert (curls[1 - outer, 1:] > 0.6).all()
        for t in (1.0, cue(played, "part").to_s):
            assert gap_m(script, t) > 0.1


@pytest.mark.long
def test_clasped_hands_are_one_blob_in_both_views_and_two_before_and_after():
    assert load_scenario("merge_and_hold").thesis == "Fig. 4.6, 4.7"
    for seed in (0, 1):
        played = performance("merge_and_hold", seed)
        held, part = cue(played, "clasp"), cue(played, "part")
        frames = [0, round(held.from_s * 3), round(part.to_s * 3) + 1]
        shown = truths(halved(played), [index / 3 for index in frames])
        merged = [[view.merged[1, 2] for view in views] for views in shown]
        assert merged == [[False, False], [True, True], [False, False]]
        for view in shown[1]:
            assert (view.visible_fractions[1:] > 0.2).all()
