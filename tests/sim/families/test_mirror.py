"""Hands that meet again and again, and cross or return each time."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from performances import cue, drawn, palms, performance, same_pictures

from sim.sequence import Simulation

SEEDS = range(4)


def merged(shot):
    """Whether the hands are one blob, per view."""
    return [bool(view.merged[1, 2]) for view in shot.truth.views]


@pytest.mark.long
def test_mirrored_hands_meet_5_to_10_times_and_cross_or_return_by_a_coin():
    kinds = []
    for seed in range(5):
        played = performance("mirror", seed)
        values = drawn("mirror", seed)
        script = played.script
        meetings = script.plan.cues
        assert len(meetings) == round(values["meetings"])
        assert 5 <= len(meetings) <= 10
        right_is_right = True
        for k, met in enumerate(meetings):
            kind, number = met.name.split(":")
            assert int(number) == k + 1
            kinds.append(kind)
            right_is_right ^= kind == "cross"
            later = (meetings[k + 1].from_s + met.to_s) / 2 if k + 1 < len(meetings) else met.to_s
            right, left = palms(script, [later])[0]
            assert (right[1] < left[1]) == right_is_right
            assert abs(right[1] + left[1]) < 0.015  # mirror images but for the tremor
    assert 0.3 < kinds.count("cross") / len(kinds) < 0.7


@pytest.mark.long
def test_up_to_a_merge_nobody_can_tell_whether_mirrored_hands_will_cross():
    crossing, returning = (
        replace(performance("mirror", 1, cross_share=share), fps=30.0, frames=1200)
        for share in (1.0, 0.0)
    )
    split_s = cue(crossing, "cross:1").from_s
    assert split_s == cue(returning, "return:1").from_s
    for t in np.linspace(0.0, split_s, 12).tolist():
        # Two motions, so two computations: 2 units of the last place apart once, why is not known.
        np.testing.assert_allclose(
            palms(crossing.script, [t]), palms(returning.script, [t]), rtol=0, atol=1e-12
        )
    with Simulation(crossing) as one, Simulation(returning) as other:
        before, after = math.floor(split_s * 30), math.ceil(split_s * 30)
        assert same_pictures(one.render(before), other.render(before))
        assert merged(one.render(after)) == merged(other.render(after)) == [True, True]
        # From the other sides as well: the second meeting of hands that crossed.
        second = math.ceil(cue(crossing, "cross:2").from_s * 30)
        assert merged(one.render(second)) == [True, True]
