"""A hand that goes behind the head."""

from __future__ import annotations

import numpy as np
import pytest
from performances import HANDS, cues, drawn, halved, performance, truths

SEEDS = range(200, 203)


def test_the_hand_behind_the_head_is_hidden_for_1_to_6_s(seed):
    played = performance("hand_behind_head", seed)
    values = drawn("hand_behind_head", seed)
    side = HANDS.index(values["hand"])
    gone = [c for c in cues(played) if c.name == "behind"]
    assert len(gone) == round(values["times"])
    assert 1.0 <= gone[0].to_s - gone[0].from_s <= 6.0
    for views in truths(halved(played), [gone[0].from_s + 0.05, gone[0].to_s - 0.05]):
        for view in views:
            assert view.visible_fractions[1 + side] < 0.1


@pytest.mark.long
@pytest.mark.parametrize("out", ["same", "other"])
def test_the_hand_comes_out_on_the_side_asked_for(out):
    played = performance("hand_behind_head", 201, out=out)
    side = HANDS.index(drawn("hand_behind_head", 201, out=out)["hand"])
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
    (views,) = truths(played, [peek])
    for view in views:
        assert view.visible_fractions[1 + side] > 0.3
        centre = view.centroids_px
        # The person's right is the picture's left.
        assert outward * (centre[1 + side, 0] - centre[0, 0]) < 0
