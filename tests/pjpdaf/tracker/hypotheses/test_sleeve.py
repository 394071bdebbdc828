"""Sleeve evidence on silhouettes that are drawn from arms."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest

from pjpdaf.camera import project
from pjpdaf.looks import CLOTHED, SKIN, Silhouette
from pjpdaf.tracker.hypotheses.geometry import Views
from pjpdaf.tracker.hypotheses.parameters import SleeveParameters
from pjpdaf.tracker.hypotheses.sleeve import Body, arm_scores, arm_values, arms
from tests.strategies import rig

CAMERAS = rig().cameras
VIEWS = Views.of(CAMERAS)
P = SleeveParameters()
HEAD = np.array([0.02, 0.0, 1.2])
BODY = Body.under(HEAD, VIEWS.axes, P)
RIGHT, LEFT = np.array([0.3, -0.25, 0.85]), np.array([0.3, 0.25, 0.85])
STEP = 4
FAR = np.array([1.0, 0.0, 0.0])


def arm(side: int, hand: np.ndarray) -> list[np.ndarray]:
    """Shoulder, elbow and hand with the elbow down and outwards."""
    elbows, penalty, _ = arms(hand[None], BODY, P)
    return [BODY.shoulders_m[side], elbows[0, side, int(penalty[0, side].argmin())], hand]


def silhouettes(*lines: list[np.ndarray]) -> tuple[Silhouette, ...]:
    shapes = []
    for camera in CAMERAS:
        classes = np.zeros((camera.height_px // STEP, camera.width_px // STEP), np.uint8)
        for points in lines:
            pixels = np.rint(project(camera, np.array(points)) / STEP).astype(np.int32)
            cv2.polylines(classes, [pixels], False, CLOTHED, thickness=9)
        shapes.append(Silhouette(classes, STEP))
    return tuple(shapes)


def scores(shapes: tuple[Silhouette, ...], hands: np.ndarray) -> np.ndarray:
    values = arm_values(shapes, VIEWS, BODY, P)
    return arm_scores(hands, values, shapes, VIEWS, BODY, P)


def test_each_hand_is_at_the_end_of_its_own_arm():
    found = scores(silhouettes(arm(0, RIGHT), arm(1, LEFT)), np.array([RIGHT, LEFT]))
    assert found[0, 0] > found[0, 1] + 0.5
    assert found[1, 1] > found[1, 0] + 0.5


def test_crossed_arms_are_told_from_uncrossed():
    right, left = np.array([0.35, 0.22, 0.95]), np.array([0.3, -0.22, 0.9])
    found = scores(silhouettes(arm(0, right), arm(1, left)), np.array([right, left]))
    assert found[0, 0] > found[0, 1]
    assert found[1, 1] > found[1, 0]


def test_arms_have_their_lengths_and_reach_the_hand():
    elbows, _, stretch = arms(np.array([RIGHT, HEAD + FAR]), BODY, P)
    upper = np.linalg.norm(elbows[0] - BODY.shoulders_m[:, None], axis=2)
    np.testing.assert_allclose(upper, P.upper_arm_m, atol=1e-9)
    fore = np.linalg.norm(elbows[0, 0] - RIGHT, axis=1)
    np.testing.assert_allclose(fore, P.forearm_m, atol=1e-9)
    assert stretch[0, 0] == 0
    assert stretch[1, 0] == pytest.approx(
        np.linalg.norm(HEAD + FAR - BODY.shoulders_m[0]) - P.upper_arm_m - P.forearm_m
    )


def test_fingers_that_point_on_along_the_forearm_speak_for_it():
    shapes = silhouettes()
    values = arm_values(shapes, VIEWS, BODY, P)
    middle = np.array([[0.35, 0.0, 0.9]])
    to_the_left = np.tile([0.3, 0.0], (2, 1, 1))  # of the person, right in the picture
    found = arm_scores(middle, values, shapes, VIEWS, BODY, P, to_the_left)
    assert found[0, 0] > found[0, 1]  # a right forearm comes from the picture's left


def test_skin_that_a_sleeve_would_hide_speaks_against_it():
    """Both hands in one blob before the chest: the left one is on the person's left."""
    shapes = silhouettes()
    left = np.array([[0.35, 0.05, 0.95]])
    for camera, shape in zip(CAMERAS, shapes, strict=True):
        shape.classes[:] = CLOTHED
        skin = np.rint(project(camera, left - np.outer([0, 1], [0, 0.1, 0])) / STEP)
        cv2.line(shape.classes, *skin.astype(int).tolist(), SKIN, thickness=12)

    def margin(covered_skin: float, bare: bool) -> float:
        p = replace(P, covered_skin=covered_skin)
        values = arm_values(shapes, VIEWS, BODY, p, bare)
        right_arm, left_arm = arm_scores(left, values, shapes, VIEWS, BODY, p)[0]
        return float(left_arm - right_arm)

    assert P.covered_skin > 0
    assert margin(P.covered_skin, bare=False) > margin(0.0, bare=False) + 0.05
    assert margin(P.covered_skin, bare=True) == margin(0.0, bare=False)


def test_without_a_silhouette_there_is_no_evidence():
    np.testing.assert_array_equal(
        arm_scores(RIGHT[None], [None, None], (None, None), VIEWS, BODY, P), np.zeros((1, 2))
    )
