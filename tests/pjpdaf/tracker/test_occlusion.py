"""Occlusion rules on gates and weights drawn by hand, and the filter behind a merged blob."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from strategies import DT_S, detections, rig

from pjpdaf.camera import project
from pjpdaf.presets.registry import PRESETS
from pjpdaf.tracker.filter import PJPDAF
from pjpdaf.tracker.occlusion import FewerMeasurements, NoOcclusion, SharedMeasurement

CAMERAS = rig().cameras
THESIS = PRESETS["thesis"].tracker


def test_occlusion_rules() -> None:
    doubt = np.full((3, 3), 0.3)
    shared = np.array([[1, 1, 0], [0, 0, 1]], dtype=bool)  # one measurement, two targets
    crowd = np.array([[1, 1, 0], [1, 1, 0], [0, 0, 1]], dtype=bool)  # two of two
    assert SharedMeasurement()(shared, doubt[:2]).tolist() == [True, True, False]
    assert SharedMeasurement()(crowd, doubt).tolist() == [True, True, False]
    assert FewerMeasurements()(shared, doubt[:2]).tolist() == [True, True, False]
    assert FewerMeasurements()(crowd, doubt).tolist() == [False, False, False]
    assert NoOcclusion()(shared, doubt[:2]).tolist() == [False, False, False]
    # Who is sure of a measurement keeps it: no merged blob, the other one was not detected.
    sure = np.array([[0.95, 0.02, 0.0], [0.0, 0.0, 0.9]])
    assert FewerMeasurements()(shared, sure).tolist() == [False, False, False]


def test_a_merged_blob_moves_nobody_and_stops_the_clock() -> None:
    points = np.array([[0.1, -0.02, 0.8], [0.1, 0.02, 0.8]])
    tracker = PJPDAF(CAMERAS, THESIS)
    state = tracker.start_at(points)
    one_blob = tuple(detections(project(camera, points.mean(axis=0))) for camera in CAMERAS)
    for _ in range(4):
        state, estimates = tracker.step(state, one_blob, DT_S)
    np.testing.assert_allclose(estimates.positions_m, points, atol=1e-12)
    assert estimates.status == ("coasting",) * 2
    assert np.all(state.unseen_s == 0.0)


@given(hnp.arrays(bool, st.tuples(st.integers(1, 5), st.integers(1, 4))), st.integers(0, 99))
def test_the_order_of_targets_and_measurements_does_not_matter(gated, seed) -> None:
    rng = np.random.default_rng(seed)
    beta = np.where(gated, rng.random(gated.shape), 0.0)
    rows, columns = rng.permutation(gated.shape[0]), rng.permutation(gated.shape[1])
    for rule in (SharedMeasurement(), FewerMeasurements(), NoOcclusion()):
        merged = rule(gated, beta)
        mixed = rule(gated[rows][:, columns], beta[rows][:, columns])
        np.testing.assert_array_equal(mixed, merged[columns])
        # A target whose gate it shares with nobody is merged with nobody.
        alone = ~(gated & (gated.sum(axis=1, keepdims=True) > 1)).any(axis=0)
        assert not merged[alone].any()
