"""A hand that touches the face."""

from __future__ import annotations

import numpy as np
import pytest
from performances import cues, drawn, performance, truths

from sim.contact.arm_shape import hand_capsules
from sim.person.head import head_surface

SEEDS = range(200, 203)


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


@pytest.mark.parametrize("place", ["cheek", "chin", "mouth", "forehead"])
def test_fingers_lie_on_the_face(place, seeds):
    for seed in seeds:
        played = performance("touch_face", seed, place=place)
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
        played, values = performance("touch_face", seed), drawn("touch_face", seed)
        touches = cues(played, "on_face")
        assert len(touches) == round(values["touches"]) >= 3
        for touch in touches:
            assert 0.5 <= touch.to_s - touch.from_s <= 3.0
        assert len({touch.name for touch in touches}) >= 3  # all places by turns


def test_a_touch_is_one_blob_with_the_face_in_both_views():
    played = performance("touch_face", 200)
    touch = cues(played, "on_face")[0]
    side = _side_that_moved(played, touch.from_s)
    (views,) = truths(played, [0.5 * (touch.from_s + touch.to_s)])
    for view in views:
        assert view.merged[0, 1 + side]
