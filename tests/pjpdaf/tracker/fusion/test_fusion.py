"""Every fusion: order, certain origins, covariances; against the Kalman filter."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from strategies import DT_S, START_W, PointWorld, calm, detections, rig

from pjpdaf.interfaces import Detections
from pjpdaf.presets.override import with_values
from pjpdaf.presets.registry import PRESETS
from pjpdaf.tracker.filter import PJPDAF
from pjpdaf.tracker.fusion.missed import ProductOfViews, SumOfViews
from pjpdaf.tracker.fusion.registry import FUSIONS
from pjpdaf.tracker.measurement import linearise
from pjpdaf.tracker.projective import update as kalman

CAMERAS = rig().cameras
THESIS = PRESETS["thesis"].tracker
CLEAN = PointWorld(noise_px=0.0, miss=0.0, clutter=0.0)
ALONE = with_values(THESIS, {"p_detect": 0.999, "clutter": 1e-6, "occlusion": "none"})


def look(points: np.ndarray, world: PointWorld = CLEAN, seed: int = 0) -> tuple[Detections, ...]:
    return world.see(CAMERAS, points, np.random.default_rng(seed))


def eigenvalues(covariances: np.ndarray) -> np.ndarray:
    return np.linalg.eigvalsh(covariances)


@settings(max_examples=30, deadline=None)
@given(st.randoms(use_true_random=False), st.integers(0, 1000), st.sampled_from(sorted(FUSIONS)))
def test_order_of_measurements_and_views_does_not_matter(random, seed, update) -> None:
    p = with_values(THESIS, {"update": update})
    world = PointWorld(noise_px=3.0, miss=0.1, clutter=2.0)
    seen = look(START_W + 0.01, world, seed)
    tracker = PJPDAF(CAMERAS, p)
    straight = tracker.step(tracker.start_at(START_W), seen, DT_S)[1]

    def mixed(view: Detections) -> Detections:
        return detections(view.centres_px[random.sample(range(len(view)), len(view))])

    shuffled = tracker.step(tracker.start_at(START_W), tuple(map(mixed, seen)), DT_S)[1]
    np.testing.assert_allclose(shuffled.positions_m, straight.positions_m, atol=1e-12)
    np.testing.assert_allclose(shuffled.covariances_m2, straight.covariances_m2, atol=1e-12)

    turned = PJPDAF(CAMERAS[::-1], p)
    other = turned.step(turned.start_at(START_W), seen[::-1], DT_S)[1]
    if update == "sequential":
        return  # each view's doubt enters the next one's gain, so there the order does matter
    np.testing.assert_allclose(other.positions_m, straight.positions_m, atol=1e-9)
    np.testing.assert_allclose(other.covariances_m2, straight.covariances_m2, atol=1e-9)


def test_certain_views_in_turn_equal_the_stack() -> None:
    seen = look(START_W + 0.005, PointWorld(1.0, 0.0, 0.0))
    outcomes = []
    for update in ("sequential", "fused", "stacked", "stacked_weighted", "most_probable"):
        p = with_values(ALONE, {"update": update})
        tracker = PJPDAF(CAMERAS, p)
        outcomes.append(tracker.step(tracker.start_at(START_W), seen, DT_S)[1])
    for estimates in outcomes[1:]:
        # 1e-5 m: beta_0 of a lone detection is about 1e-6 here, not 0.
        np.testing.assert_allclose(estimates.positions_m, outcomes[0].positions_m, atol=1e-5)
        np.testing.assert_allclose(
            estimates.covariances_m2, outcomes[0].covariances_m2, rtol=1e-3, atol=1e-7
        )


def test_equal_to_the_kalman_filter_where_origins_are_certain() -> None:
    tracker = PJPDAF(CAMERAS, with_values(ALONE, {"update": "stacked"}))
    state = tracker.start_at(START_W[:1])
    seen = look(START_W[:1] + 0.005)
    prior, _ = tracker.associate(state, seen, DT_S)
    z, H, _ = linearise(tracker._projection, prior.mean[:, :3], False)
    innovation = np.array([view.centres_px[0] for view in seen]) - z[:, 0]
    mean, P = kalman(
        prior.mean[0], prior.P[0], innovation.ravel(), H.reshape(4, 6), 15.0 * np.eye(4)
    )
    after, _ = tracker.step(state, seen, DT_S)
    np.testing.assert_allclose(after.mean[0], mean, atol=1e-6)
    np.testing.assert_allclose(after.covariance[0], P, rtol=1e-3, atol=1e-8)


@pytest.mark.parametrize("name", ["thesis", "thesis-literal"])
@pytest.mark.parametrize("update", sorted(FUSIONS))
def test_covariances_stay_symmetric_positive_definite(name: str, update: str) -> None:
    p = with_values(PRESETS[name].tracker, {"update": update})
    tracker, rng = PJPDAF(CAMERAS, p), np.random.default_rng(2)
    state = tracker.start_at(START_W)
    world = PointWorld(noise_px=4.0, miss=0.3, clutter=3.0, merge_px=40.0)
    for k in range(40):
        points = calm(2.0 * k * DT_S)  # twice as fast, so that things go wrong too
        state, _ = tracker.step(state, world.see(CAMERAS, points, rng), DT_S)
        np.testing.assert_array_equal(state.covariance, state.covariance.swapaxes(1, 2))
        assert np.all(eigenvalues(state.covariance) > 0)
        assert np.all(np.isfinite(state.mean))


@pytest.mark.parametrize("fusion", sorted(FUSIONS))
def test_a_view_that_is_merged_or_missing_takes_no_part(fusion: str) -> None:
    """Garbage in the view that is left out changes nothing."""
    tracker = PJPDAF(CAMERAS, THESIS)
    prior, association = tracker.associate(tracker.start_at(START_W), look(START_W + 0.005), DT_S)
    for present, merged in ((False, False), (True, True)):
        results = []
        for garbage in (0.0, 30.0):
            seen = association._replace(
                innovation=association.innovation.copy(),
                best=association.best.copy(),
                present=association.present.copy(),
                merged=association.merged.copy(),
            )
            seen.present[:, 1], seen.merged[:, 1] = present, merged
            seen.innovation[:, 1], seen.best[:, 1] = garbage, garbage
            results.append(FUSIONS[fusion](prior, seen, ProductOfViews()))
        for a, b in zip(*results, strict=True):
            np.testing.assert_array_equal(a, b)


def test_weights_of_not_detected_over_the_views() -> None:
    beta_0 = np.array([[0.2, 0.9], [0.5, 0.5]])
    present = np.array([[True, True], [True, False]])
    used = np.array([[True, False], [True, False]])
    np.testing.assert_allclose(SumOfViews()(beta_0, present, used), [1.1, 0.5])
    np.testing.assert_allclose(ProductOfViews()(beta_0, present, used), [0.2, 0.5])
