"""A watch that cuts a bare arm in two at the start."""

from __future__ import annotations

import numpy as np
import pytest

from pjpdaf.camera import Camera, project
from pjpdaf.interfaces import Detections
from pjpdaf.tracker.hypotheses.parameters import (
    CandidateParameters,
    HypothesisParameters,
    OffsetParameters,
)
from pjpdaf.tracker.hypotheses.tracker import HypothesisTracker
from tests.strategies import detections

K = np.array([[600.0, 0, 640], [0, 600, 360], [0, 0, 1]])
CAMERAS = tuple(Camera(K, np.eye(3), np.array([x, 0.0, 0.0]), 1280, 720) for x in (0.0, -0.3))
HEAD, RIGHT, LEFT, LEFT_FOREARM = (
    (0.20, -0.10, 0.93),
    (-0.11, 0.11, 0.72),
    (0.24, 0.13, 0.70),
    (0.38, 0.33, 0.82),
)
PLACES = np.array([HEAD, RIGHT, LEFT, LEFT_FOREARM])
AREAS_PX = np.array([9000.0, 5000, 7000, 8000])
NONE = (0.0, 0.0, 0.0)


def seen() -> tuple[Detections, ...]:
    return tuple(detections(project(camera, PLACES), AREAS_PX) for camera in CAMERAS)


def hands_after(frames: int, arm_pieces: bool) -> np.ndarray:
    parameters = HypothesisParameters(
        offsets=OffsetParameters(NONE, NONE), candidates=CandidateParameters(arm_pieces=arm_pieces)
    )
    tracker = HypothesisTracker(CAMERAS, parameters)
    state = tracker.start(seen())
    assert state is not None
    estimates = tracker.estimates(state)
    for _ in range(frames):
        state, estimates = tracker.step(state, seen(), 1 / 3)
    return np.asarray(estimates.positions_m)


@pytest.mark.parametrize("frames", [0, 1, 3])
def test_both_hands_start_on_hands(frames):
    np.testing.assert_allclose(hands_after(frames, arm_pieces=True), PLACES[:3], atol=0.01)


def test_without_the_part_a_hand_starts_on_its_forearm():
    assert np.linalg.norm(hands_after(0, arm_pieces=False)[2] - LEFT) > 0.1
