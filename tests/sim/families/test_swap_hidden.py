"""Hands that swap behind a screen, or do not."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from performances import cue, gap_m, halved, palms, performance, truths

from scenarios.spec.draw import concrete
from scenarios.spec.names import load_scenario

SEEDS = range(4)


@pytest.mark.parametrize("outcome", ["crossed", "same"])
def test_a_screen_hides_both_hands_in_both_views_and_shows_them_before_and_after(outcome):
    played = performance("swap_hidden", 2, outcome=outcome)
    hidden, out = cue(played, "hidden"), cue(played, f"out:{outcome}")
    first, last = math.ceil(hidden.from_s * 3), math.floor(hidden.to_s * 3)
    frames = (first, (first + last) // 2, last, 0, math.ceil(out.from_s * 3))
    *behind, before, after = truths(halved(played), [index / 3 for index in frames])
    for view in itertools.chain(*behind):
        assert (view.visible_fractions[1:] < 0.1).all()
        assert view.visible_fractions[0] > 0.95  # the face is not cut
    for view in (*before, *after):
        assert (view.visible_fractions > 0.6).all()


@pytest.mark.long
def test_hands_are_out_of_sight_for_1_to_4_s():
    for seed, hidden_s in ((0, 0.7), (1, 3.2)):
        fps = 6
        played = performance("swap_hidden", seed, hidden=hidden_s)
        hidden = cue(played, "hidden")
        edge = range(math.floor((hidden.from_s - 1.0) * fps), math.ceil(hidden.from_s * fps))
        shown = truths(halved(played), [index / fps for index in edge])
        unseen = sum(
            all((view.visible_fractions[1:] < 0.1).all() for view in views) for views in shown
        )
        # The way out is the way in reversed: the same time again.
        total_s = hidden.to_s - hidden.from_s + 2 * unseen / fps
        assert 0.9 <= total_s <= 4.4


@pytest.mark.long
def test_swapped_hands_do_not_touch_and_come_out_at_the_same_places(seeds):
    ends = {}
    for outcome in ("crossed", "same"):
        for seed in seeds:
            played = performance("swap_hidden", seed, outcome=outcome)
            hidden, out = cue(played, "hidden"), cue(played, f"out:{outcome}")
            times = np.arange(hidden.from_s - 1.0, out.from_s + 0.5, 0.1).tolist()
            assert min(gap_m(played.script, t) for t in times) > 0.0
            right, left = palms(played.script, [out.from_s + 0.5])[0]
            assert (right[1] > left[1]) == (outcome == "crossed")
            ends[outcome, seed] = sorted([right[1], left[1]])
            assert f"out:{outcome}" in played.script.events(out.from_s)
    for seed in seeds:
        np.testing.assert_allclose(ends["crossed", seed], ends["same", seed], atol=0.008)


def test_half_of_the_draws_come_out_crossed():
    scenario = load_scenario("swap_hidden")
    drawn = [concrete(scenario, seed)["outcome"] for seed in range(200)]
    assert 0.4 < drawn.count("crossed") / 200 < 0.6
