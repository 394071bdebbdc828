"""Before the start: the head alone, and with a hand that can be named."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest

from pjpdaf.camera import project
from pjpdaf.interfaces import Detections
from pjpdaf.looks import CLOTHED, Silhouette, looks_of_ellipses
from pjpdaf.targets import HEAD, LEFT_HAND, RIGHT_HAND
from pjpdaf.tracker.hypotheses.early import Early
from pjpdaf.tracker.hypotheses.tracker import HypothesisState, HypothesisTracker
from tests.pjpdaf.tracker.hypotheses.test_tracker import AREAS, CAMERAS, PLAIN, START_W
from tests.pjpdaf.tracker.hypotheses.test_tracker import seen as points_seen

STEP = 4
HAIR_M, TORSO_M = 0.16, 0.45
PLACED = {HEAD: 0, RIGHT_HAND: 1, LEFT_HAND: 2}


def seen(*targets: int, hair: bool = True) -> tuple[Detections, ...]:
    """Blobs of some of the targets, and the silhouette of the person who has them all."""
    rows = np.array([PLACED[target] for target in targets])
    views = []
    for camera, view in zip(CAMERAS, points_seen(START_W[rows], AREAS[rows]), strict=True):
        classes = np.zeros((camera.height_px // STEP, camera.width_px // STEP), np.uint8)
        top = [0.0, 0.0, HAIR_M if hair else 0.5]
        trunk = START_W[0] + [top, [0.0, 0.0, -TORSO_M]]
        neck, side = START_W[0] + [0.0, 0.0, -0.165], np.array([0.0, 0.175, 0.0])
        right, left = [neck, neck - side, START_W[1]], [neck, neck + side, START_W[2]]
        for line in (trunk, np.array(right), np.array(left)):
            pixels = np.rint(project(camera, line) / STEP).astype(np.int32)
            cv2.polylines(classes, [pixels], False, CLOTHED, thickness=9)
        looks = replace(looks_of_ellipses(view.ellipses), silhouette=Silhouette(classes, STEP))
        views.append(replace(view, looks=looks))
    return tuple(views)


@pytest.mark.parametrize("hand", [RIGHT_HAND, LEFT_HAND])
def test_head_and_the_hand_that_shows_are_told_before_the_other_shows(hand):
    tracker = HypothesisTracker(CAMERAS, PLAIN)
    state = tracker.start(seen(HEAD, hand))
    assert isinstance(state, Early)
    said = tracker.estimates(state)
    hidden = RIGHT_HAND + LEFT_HAND - hand
    assert said.status[hidden] == "waiting"
    assert np.isnan(said.positions_m[hidden]).all()
    np.testing.assert_allclose(said.positions_m[HEAD, :2], START_W[0, :2], atol=0.01)
    np.testing.assert_allclose(said.positions_m[hand], START_W[PLACED[hand]], atol=0.01)
    assert tracker.predict(state, 1 / 3).status == ("waiting",) * 3
    assert tracker.smoothed((state, state)) is said
    state, said = tracker.step(state, seen(HEAD, RIGHT_HAND, LEFT_HAND), 1 / 3)
    assert isinstance(state, HypothesisState)
    assert said.status == ("tracked",) * 3


def test_a_blob_without_hair_above_it_is_no_head():
    assert HypothesisTracker(CAMERAS, PLAIN).start(seen(HEAD, hair=False)) is None


def test_a_head_alone_and_nothing():
    tracker = HypothesisTracker(CAMERAS, PLAIN)
    state = tracker.start(seen(HEAD))
    assert isinstance(state, Early)
    assert tracker.estimates(state).status == ("tracked", "waiting", "waiting")
    state, said = tracker.step(state, (Detections.none(), Detections.none()), 1 / 3)
    assert said.status == ("waiting",) * 3
    state, said = tracker.step(state, seen(HEAD, LEFT_HAND), 1 / 3)
    assert said.status == ("tracked", "waiting", "tracked")


def test_it_waits_for_all_three_without_the_part():
    tracker = HypothesisTracker(CAMERAS, replace(PLAIN, early=False))
    assert tracker.start(seen(HEAD, LEFT_HAND)) is None
