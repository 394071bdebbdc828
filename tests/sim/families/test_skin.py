"""Skin that belongs to no target: a block of its colour, bare forearms."""

from __future__ import annotations

import numpy as np
import pytest
from performances import HANDS, components_px, cue, cues, drawn, end_s, performance, renders

from pjpdaf.detector.parameters import DetectorParameters
from pjpdaf.detector.skin import skin_mask, to_hsv
from sim.vectors import norm

SEEDS = range(200, 203)


def pixels_of(view, world, word):
    """Mask of the geoms whose names contain a word."""
    named = [g for g in range(world.model.ngeom) if word in world.model.geom(g).name]
    assert named
    return np.isin(view.geoms, named)


def skin(picture):
    """Where the detector's default range takes a picture for skin."""
    return skin_mask(to_hsv(picture), DetectorParameters().skin) > 0


@pytest.mark.long
def test_the_block_has_the_colour_of_skin_and_joins_the_hand_that_carries_it(seeds):
    shares = []
    for seed in seeds:
        played = performance("skin_coloured_object", seed)
        carried = cue(played, "carried")
        ((views, _, world),) = renders(played, [0.5 * (carried.from_s + carried.to_s)], colour=True)
        hand = 1 + HANDS.index(drawn("skin_coloured_object", seed)["hand"])
        for view in views:
            block, mine = pixels_of(view, world, "object:block"), view.targets == hand
            found = skin(view.colour)
            shares.append([found[block].mean(), found[mine].mean(), block.sum() / mine.sum()])
            assert len([s for s in components_px(block | mine) if s > 50]) == 1
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


@pytest.mark.long
def test_bare_forearms_are_skin_that_belongs_to_no_target(seeds):
    for seed in seeds:
        played = performance("bare_forearm", seed)
        assert played.scene.appearance.sleeves in ("rolled", "short")
        stand = cues(played, "stand:")
        times = [c.to_s - 0.05 for c in stand if c.to_s < end_s(played)][:2]
        for views, shown, world in renders(played, times, colour=True):
            for view, truth in zip(views, shown, strict=True):
                bare = pixels_of(view, world, "bare:forearm")
                assert (view.targets[bare] == -1).all()
                assert bare.sum() > 0.3 * truth.visible_px[1:].sum()
                assert skin(view.colour)[bare].mean() > 0.7


def test_bare_forearms_stand_lie_and_spread_in_both_hands(seeds):
    for seed in seeds:
        names = {c.name for c in cues(performance("bare_forearm", seed))}
        assert len(names) >= 4
        assert {name.partition(":")[2] for name in names} == set(HANDS)
