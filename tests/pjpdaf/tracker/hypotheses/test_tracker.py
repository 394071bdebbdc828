"""The hypothesis tracker on drawn silhouettes and on bare points."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from pjpdaf.camera import project
from pjpdaf.interfaces import Detections
from pjpdaf.tracker.hypotheses.hypothesis import Hypothesis
from pjpdaf.tracker.hypotheses.parameters import HypothesisParameters, OffsetParameters
from pjpdaf.tracker.hypotheses.readout import exchange_probability
from pjpdaf.tracker.hypotheses.tracker import HypothesisTracker
from tests.strategies import detections, rig

CAMERAS = rig().cameras
START_W = np.array([[0.0, 0.0, 1.2], [0.1, -0.2, 0.8], [0.1, 0.2, 0.8]])
AREAS = np.array([4500.0, 1500, 1500])
NO_OFFSET = (0.0, 0.0, 0.0)
PLAIN = HypothesisParameters(offsets=OffsetParameters(NO_OFFSET, NO_OFFSET, outward_m=0.0))
FRAME_S = 1 / 3


def tracker(parameters: HypothesisParameters = PLAIN) -> HypothesisTracker:
    return HypothesisTracker(CAMERAS, parameters)


def seen(points: np.ndarray, areas: np.ndarray = AREAS) -> tuple[Detections, ...]:
    return tuple(detections(project(camera, points), areas) for camera in CAMERAS)


def nothing() -> tuple[Detections, ...]:
    return Detections.none(), Detections.none()


def test_three_blobs_start_it_where_they_are():
    one = tracker()
    state = one.start(seen(START_W))
    assert state is not None
    np.testing.assert_allclose(one.estimates(state).positions_m, START_W, atol=1e-6)
    assert one.estimates(state).status == ("tracked",) * 3


@pytest.mark.parametrize("missing", [0, 1, 2])
def test_it_waits_for_all_three(missing):
    rest = np.delete(np.arange(3), missing)
    assert tracker().start(seen(START_W[rest], AREAS[rest])) is None
    assert tracker().start(nothing()) is None


def test_two_pieces_of_one_arm_are_not_two_hands():
    """A wrist watch cuts a bare left arm in two; the right hand is hidden."""
    pieces = START_W.copy()
    pieces[1] = START_W[2] + (0.0, -0.03, 0.09)
    assert tracker().start(seen(pieces)) is None


@pytest.mark.parametrize("dt_s", [1 / 30, FRAME_S, 1.0])
def test_hands_that_move_apart_are_followed(dt_s):
    one = tracker()
    state = one.start(seen(START_W))
    assert state is not None
    velocity = np.array([[0.0, 0, 0], [0.1, -0.1, 0.1], [0.1, 0.1, 0.0]])
    for k in range(1, 5):
        truth = START_W + velocity * min(k * dt_s, 1.5)
        state, estimates = one.step(state, seen(truth), dt_s)
    np.testing.assert_allclose(estimates.positions_m, truth, atol=0.01)


def test_hidden_hand_coasts_is_lost_and_comes_back_anywhere():
    one = tracker()
    state = one.start(seen(START_W))
    assert state is not None
    status = []
    for _ in range(5):
        state, estimates = one.step(state, seen(START_W[:2], AREAS[:2]), FRAME_S)
        status.append(estimates.status[2])
    assert status[0] == "coasting"
    assert status[-1] == "lost"
    away = START_W.copy()
    away[2] = (0.3, 0.45, 1.1)
    for _ in range(3):
        state, estimates = one.step(state, seen(away), FRAME_S)
    assert estimates.status == ("tracked",) * 3
    np.testing.assert_allclose(estimates.positions_m, away, atol=0.02)


def test_lost_view_leaves_estimates_finite():
    one = tracker()
    state = one.start(seen(START_W))
    assert state is not None
    left, _ = seen(START_W)
    for _ in range(2):
        state, estimates = one.step(state, (left, Detections.none(missing=True)), FRAME_S)
        assert np.isfinite(estimates.positions_m).all()
    np.testing.assert_allclose(estimates.positions_m, START_W, atol=0.05)
    assert np.linalg.eigvalsh(estimates.covariances_m2).min() > 0


def test_frames_without_blobs_change_no_place():
    one = tracker()
    state = one.start(seen(START_W))
    assert state is not None
    for _ in range(30):
        state, estimates = one.step(state, nothing(), FRAME_S)
    np.testing.assert_allclose(estimates.positions_m, START_W, atol=1e-6)
    assert estimates.status == ("lost",) * 3


def test_order_of_blobs_does_not_matter():
    order = [2, 0, 1]
    estimates = []
    for index in (range(3), order):
        one = tracker()
        state = one.start(seen(START_W[list(index)], AREAS[list(index)]))
        assert state is not None
        moved = START_W + np.array([0.02, 0.0, 0.01])
        estimates.append(one.step(state, seen(moved[list(index)], AREAS[list(index)]), FRAME_S)[1])
    np.testing.assert_allclose(estimates[0].positions_m, estimates[1].positions_m, atol=1e-9)


def test_evidence_of_the_detector_exchanges_hands_after_a_merge():
    """Hands meet and part again; which is which only the detector's evidence tells."""
    together = START_W.copy()
    together[1:] = (0.2, 0.0, 0.85)
    for exchanged in (False, True):
        one = tracker()
        state = one.start(seen(START_W))
        assert state is not None
        merged = together[:2], np.array([4500.0, 2800.0])
        for _ in range(2):
            state, _ = one.step(state, seen(*merged), FRAME_S)
        for _ in range(4):
            log = np.zeros((3, 3))
            right, left = (2, 1) if exchanged else (1, 2)
            log[right, 2] = log[left, 1] = -6.0
            views = tuple(dataclasses.replace(view, evidence=log) for view in seen(START_W))
            state, estimates = one.step(state, views, FRAME_S)
        hands = START_W[[2, 1]] if exchanged else START_W[1:]
        np.testing.assert_allclose(estimates.positions_m[1:], hands, atol=0.03)


def test_exchange_probability_is_the_weight_of_the_exchanged():
    hands = np.array([[0.1, -0.2, 0.8], [0.1, 0.2, 0.8]])
    P = np.tile(np.eye(3) * 1e-4, (2, 1, 1))
    straight = Hypothesis(0.0, 0.0, hands, P, np.zeros(2))
    exchanged = Hypothesis(np.log(4.0), 0.0, hands[::-1], P, np.zeros(2))
    assert exchange_probability((straight, exchanged)) == pytest.approx(0.2)
    assert exchange_probability((straight,)) == 0.0


def test_needs_two_views():
    with pytest.raises(ValueError, match="needs 2 cameras, got 1"):
        HypothesisTracker(CAMERAS[:1])
