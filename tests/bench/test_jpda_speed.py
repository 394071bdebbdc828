"""Speed of association and of a whole step, as ratios to Stone Soup within one run.

Never fails by the clock: the ratio is printed in the benchmark's extra information. Run with
`pytest tests/bench --benchmark-enable`.
"""

from __future__ import annotations

from datetime import datetime
from statistics import median
from time import perf_counter

import numpy as np
import pytest
from stonesoup.dataassociator.probability import JPDA
from stonesoup.functions import gm_reduce_single
from stonesoup.gater.distance import DistanceGater
from stonesoup.hypothesiser.probability import PDAHypothesiser
from stonesoup.measures import SquaredMahalanobis
from stonesoup.models.measurement.linear import LinearGaussian
from stonesoup.models.transition.linear import CombinedLinearGaussianTransitionModel, RandomWalk
from stonesoup.predictor.kalman import KalmanPredictor
from stonesoup.types.array import StateVectors
from stonesoup.types.detection import Detection
from stonesoup.types.state import GaussianState
from stonesoup.types.track import Track
from stonesoup.updater.kalman import KalmanUpdater
from strategies import DT_S, detections, rig

from pjpdaf.camera import project
from pjpdaf.presets.registry import PRESETS
from pjpdaf.tracker.filter import PJPDAF
from pjpdaf.tracker.jpda import association_probabilities

CAMERAS = rig().cameras
NEAR_W = np.array([[0.1, -0.012, 0.8], [0.1, 0.0, 0.812], [0.1, 0.012, 0.8]])  # gates overlap


def pictures(rng: np.random.Generator) -> list[np.ndarray]:
    """Six measurements in each of two views, every one within reach of three targets."""
    return [np.repeat(project(c, NEAR_W), 2, axis=0) + rng.normal(0, 4, (6, 2)) for c in CAMERAS]


def seconds(call, rounds: int) -> float:
    """Median over `rounds` calls, after one to warm up."""
    call()
    times = []
    for _ in range(rounds):
        begin = perf_counter()
        call()
        times.append(perf_counter() - begin)
    return median(times)


def stone_soup(pixels: list[np.ndarray], P: np.ndarray):
    """One associate call a camera on predictions of the same pixels and covariances.

    Two callables: that alone, and with the update that follows it in Stone Soup's JPDA loop (each
    hypothesis updated, the mixture reduced to one Gaussian a track).
    """
    now = datetime(2009, 1, 1)
    model = LinearGaussian(2, (0, 1), np.diag([15.0, 15.0]))
    updater = KalmanUpdater(model)
    standing = CombinedLinearGaussianTransitionModel([RandomWalk(0.0), RandomWalk(0.0)])
    hypothesiser = DistanceGater(
        PDAHypothesiser(
            KalmanPredictor(standing),
            updater,
            clutter_spatial_density=1e-5,
            prob_detect=0.9,
            prob_gate=1.0,
        ),
        SquaredMahalanobis(),
        15.0,
    )
    views = [
        (
            [Track([GaussianState(z, P, timestamp=now)]) for z in project(camera, NEAR_W)],
            {Detection(z, timestamp=now, measurement_model=model) for z in seen},
        )
        for camera, seen in zip(CAMERAS, pixels, strict=True)
    ]
    associator = JPDA(hypothesiser)

    def associate() -> None:
        for tracks, seen in views:
            associator.associate(tracks, seen, now)

    def step() -> None:
        for tracks, seen in views:
            for hypotheses in associator.associate(tracks, seen, now).values():
                states = [updater.update(h) if h else h.prediction for h in hypotheses]
                gm_reduce_single(
                    StateVectors([state.state_vector for state in states]),
                    np.stack([state.covar for state in states], axis=2),
                    np.asarray([h.probability for h in hypotheses], dtype=float),
                )

    return associate, step


def test_step_of_three_targets_six_measurements_two_views(benchmark) -> None:
    pixels = pictures(np.random.default_rng(1))
    tracker = PJPDAF(CAMERAS, PRESETS["thesis"].tracker)
    state, seen = tracker.start_at(NEAR_W), tuple(map(detections, pixels))
    prior, association = tracker.associate(state, seen, DT_S)
    assert np.all(association.beta_0 < 0.5)
    H = prior.H[0, 0]
    associate, step = stone_soup(pixels, H @ prior.P[0] @ H.T)
    if benchmark.enabled:
        parts = {"association": tracker.associate, "step": tracker.step}
        for (name, part), theirs in zip(parts.items(), (associate, step), strict=True):
            ours_s = seconds(lambda part=part: part(state, seen, DT_S), 500)
            ratio = seconds(theirs, 25) / ours_s
            benchmark.extra_info[f"{name}, times faster than Stone Soup"] = ratio
    else:
        step()
    benchmark(tracker.step, state, seen, DT_S)


@pytest.mark.parametrize(("m", "T"), [(6, 3), (15, 10)])
def test_association_where_all_gates_overlap(benchmark, m: int, T: int) -> None:
    L, gated = np.random.default_rng(2).random((m, T)), np.ones((m, T), dtype=bool)
    beta = benchmark(association_probabilities, L, gated, 0.9, 0.1)
    np.testing.assert_allclose(beta.sum(axis=0), 1.0)
