"""Data association against the thesis's example, brute force and Stone Soup."""

from __future__ import annotations

from collections.abc import Iterator
from datetime import datetime

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from stonesoup.dataassociator.probability import JPDA
from stonesoup.gater.distance import DistanceGater
from stonesoup.hypothesiser.probability import PDAHypothesiser
from stonesoup.measures import SquaredMahalanobis
from stonesoup.models.measurement.linear import LinearGaussian
from stonesoup.models.transition.linear import CombinedLinearGaussianTransitionModel, RandomWalk
from stonesoup.predictor.kalman import KalmanPredictor
from stonesoup.types.detection import Detection
from stonesoup.types.state import GaussianState
from stonesoup.types.track import Track
from stonesoup.updater.kalman import KalmanUpdater
from strategies import association_cases

from pjpdaf.tracker import jpda
from pjpdaf.tracker.jpda import association_probabilities, clusters, squared_distances

# Rounding of sums over at most a few thousand events.
EXACT = 1e-12


def validation_matrix(gated: np.ndarray) -> np.ndarray:
    """Omega of Eq. 3.28: gated (m, T) with the clutter column in front, (m, T + 1)."""
    return np.column_stack([np.ones(len(gated), dtype=bool), gated])


def feasible_events(omega: np.ndarray) -> Iterator[tuple[int, ...]]:
    """All feasible events of a validation matrix (m, T + 1), clutter in column 0 (section 3.4.2).

    An event is the origin of each measurement, 0 for clutter: one origin a measurement, at most
    one measurement a target. There are exponentially many; `association_probabilities` does not
    need them.
    """
    rows = [tuple(np.flatnonzero(row).tolist()) for row in np.asarray(omega, dtype=bool)]

    def extend(event: tuple[int, ...]) -> Iterator[tuple[int, ...]]:
        if len(event) == len(rows):
            yield event
            return
        for origin in rows[len(event)]:
            if origin == 0 or origin not in event:
                yield from extend((*event, origin))

    return extend(())


def enumerated(
    likelihood: np.ndarray, gated: np.ndarray, p_detect: float, clutter: float
) -> np.ndarray:
    """Eq. 3.32-3.34 as printed: every feasible event is written down."""
    m, T = likelihood.shape
    beta, total = np.zeros((m + 1, T)), 0.0
    for event in feasible_events(validation_matrix(gated)):
        weight = 1.0
        for j, origin in enumerate(event):
            weight *= likelihood[j, origin - 1] if origin else clutter
        detected = {origin - 1 for origin in event if origin}
        weight *= p_detect ** len(detected) * (1 - p_detect) ** (T - len(detected))
        total += weight
        for t in range(T):
            j = event.index(t + 1) + 1 if t in detected else 0
            beta[j, t] += weight
    return beta / total


def test_thesis_figure_3_12_has_eight_events() -> None:
    omega = np.array([[1, 1, 0], [1, 1, 1], [1, 0, 1]], dtype=bool)  # columns clutter, t1, t2
    events = list(feasible_events(omega))
    assert len(events) == 8
    # Hypothesis matrices 0 to 7 of section 3.4.2: the origin of z1, z2, z3.
    assert set(events) == {
        (0, 0, 0),
        (1, 0, 0),
        (1, 2, 0),
        (1, 0, 2),
        (0, 1, 0),
        (0, 1, 2),
        (0, 2, 0),
        (0, 0, 2),
    }


def test_validation_matrix_has_the_clutter_column_in_front() -> None:
    gated = np.array([[True, False], [True, True]])
    np.testing.assert_array_equal(validation_matrix(gated), [[1, 1, 0], [1, 1, 1]])


def test_equal_to_enumeration_on_1000_random_cases() -> None:
    rng = np.random.default_rng(34)
    for _ in range(1000):
        m, T = int(rng.integers(0, 6)), int(rng.integers(1, 5))
        likelihood = np.exp(rng.uniform(-12, 0, (m, T)))
        gated = rng.random((m, T)) < 0.6
        p_detect, clutter = rng.uniform(0.05, 0.99), 10 ** rng.uniform(-6, 0)
        np.testing.assert_allclose(
            association_probabilities(likelihood, gated, p_detect, clutter),
            enumerated(likelihood, gated, p_detect, clutter),
            atol=EXACT,
        )


def stone_soup(
    means: np.ndarray, covariances: np.ndarray, pixels: np.ndarray, clutter: float
) -> np.ndarray:
    """Weights (m + 1, T) by Stone Soup's JPDA: C is its clutter density, prob_gate is 1."""
    now = datetime(2009, 1, 1)
    model = LinearGaussian(2, (0, 1), np.diag([15.0, 15.0]))
    standing = CombinedLinearGaussianTransitionModel([RandomWalk(0.0), RandomWalk(0.0)])
    updater = KalmanUpdater(model)
    hypothesiser = DistanceGater(
        PDAHypothesiser(
            KalmanPredictor(standing),
            updater,
            clutter_spatial_density=clutter,
            prob_detect=0.9,
            prob_gate=1.0,
        ),
        SquaredMahalanobis(),
        15.0,
    )
    tracks = [
        Track([GaussianState(mean, P, timestamp=now)])
        for mean, P in zip(means, covariances, strict=True)
    ]
    seen = [Detection(z, timestamp=now, measurement_model=model) for z in pixels]
    found = JPDA(hypothesiser).associate(tracks, set(seen), now)
    beta = np.zeros((len(seen) + 1, len(tracks)))
    for t, track in enumerate(tracks):
        for hypothesis in found[track]:
            row = next((j + 1 for j, z in enumerate(seen) if hypothesis.measurement is z), 0)
            beta[row, t] = float(hypothesis.probability)
    return beta


def test_equal_to_stone_soup_on_200_random_cases() -> None:
    rng = np.random.default_rng(2009)
    overlaps = 0
    for _ in range(200):
        m, T = int(rng.integers(1, 5)), int(rng.integers(1, 4))
        means, pixels = rng.uniform(0, 40, (T, 2)), rng.uniform(0, 40, (m, 2))
        A = rng.normal(0, 6, (T, 2, 2))
        P = A @ A.swapaxes(1, 2) + np.eye(2)
        S = P + 15.0 * np.eye(2)
        clutter = 10 ** rng.uniform(-6, -1)
        d2 = squared_distances(pixels[:, None] - means, np.linalg.inv(S))
        gated = d2 < 15.0
        overlaps += bool((gated.sum(axis=1) > 1).any())
        likelihood = np.exp(-0.5 * d2) / np.sqrt(np.linalg.det(2 * np.pi * S))
        np.testing.assert_allclose(
            association_probabilities(likelihood, gated, 0.9, clutter),
            stone_soup(means, P, pixels, clutter),
            atol=1e-9,
        )
    assert overlaps > 50  # or the test would not test the joint part


@pytest.mark.parametrize("spread", [1.0, 300.0, 3000.0])
def test_all_three_recursions_agree(spread: float) -> None:
    rng = np.random.default_rng(7)
    for _ in range(20):
        L = 10 ** (-rng.uniform(0, spread / 20, (4, 3)))
        C, PD = np.full(4, 10 ** (-spread / 20)), rng.uniform(0.1, 0.99, 3)
        L[np.arange(4), rng.integers(0, 3, 4)] = 1.0
        slow = jpda._logarithmic(L, C, PD)
        if spread < 3000.0:
            np.testing.assert_allclose(jpda._by_matrices(L, C, PD), slow, atol=EXACT)
            np.testing.assert_allclose(jpda._linear(L, C, PD), slow, atol=EXACT)
        np.testing.assert_allclose(
            association_probabilities(L, np.ones((4, 3), bool), PD, C[0])[1:], slow, atol=EXACT
        )


def test_far_below_what_a_product_of_floats_can_hold() -> None:
    # Two targets, two measurements at 1e-200 of clutter each: both are clutter, and of the two
    # ways to be detected the better one wins by their ratio.
    L = np.array([[1e-200, 1e-203], [1e-203, 1e-200]])
    beta = association_probabilities(L, np.ones((2, 2), bool), 0.5, 1.0)
    np.testing.assert_allclose(beta[0], 1.0)
    beta = association_probabilities(L, np.ones((2, 2), bool), 1.0, 1.0)
    np.testing.assert_allclose(beta[1:], [[1, 1e-6], [1e-6, 1]], rtol=1e-5)


@given(association_cases(), st.floats(0.01, 0.99), st.floats(1e-6, 1.0))
def test_each_target_has_one_origin_or_none(case, p_detect, clutter) -> None:
    likelihood, gated = case
    beta = association_probabilities(likelihood, gated, p_detect, clutter)
    assert np.all((beta >= 0.0) & (beta <= 1.0 + EXACT))
    np.testing.assert_allclose(beta.sum(axis=0), 1.0, atol=EXACT)
    assert np.all(beta[1:].sum(axis=1) <= 1.0 + EXACT)  # a measurement has at most one origin
    assert np.all(beta[1:][~gated] == 0.0)


@given(association_cases(), st.randoms(use_true_random=False))
def test_order_of_measurements_and_targets_does_not_matter(case, random) -> None:
    likelihood, gated = case
    rows = random.sample(range(len(likelihood)), len(likelihood))
    columns = random.sample(range(likelihood.shape[1]), likelihood.shape[1])
    straight = association_probabilities(likelihood, gated, 0.9, 0.1)
    L, G = likelihood[rows][:, columns], gated[rows][:, columns]
    shuffled = association_probabilities(L, G, 0.9, 0.1)
    np.testing.assert_allclose(shuffled[0], straight[0][columns], atol=EXACT)
    np.testing.assert_allclose(shuffled[1:], straight[1:][rows][:, columns], atol=EXACT)


def test_targets_far_apart_do_not_know_of_each_other() -> None:
    rng = np.random.default_rng(3)
    sizes = [(2, 3), (3, 2), (1, 4)]  # 9 targets: more than one recursion takes on
    blocks = [rng.random(size) for size in sizes]
    L, gated = np.zeros((6, 9)), np.zeros((6, 9), dtype=bool)
    expected = np.zeros((7, 9))
    row = column = 0
    for block in blocks:
        m, T = block.shape
        here = np.s_[row : row + m, column : column + T]
        L[here], gated[here] = block, True
        alone = association_probabilities(block, np.ones((m, T), bool), 0.9, 0.1)
        expected[0, column : column + T] = alone[0]
        expected[1 + row : 1 + row + m, column : column + T] = alone[1:]
        row, column = row + m, column + T
    np.testing.assert_allclose(association_probabilities(L, gated, 0.9, 0.1), expected, atol=EXACT)


def test_clusters_join_targets_over_shared_measurements() -> None:
    gated = np.array([[1, 1, 0, 0, 0], [0, 1, 0, 1, 0], [0, 0, 1, 0, 0]], dtype=bool)
    assert clusters(gated) == [([2], [2]), ([0, 1, 3], [0, 1]), ([4], [])]


def test_ten_targets_and_fifteen_measurements_all_overlapping() -> None:
    rng = np.random.default_rng(5)
    L = rng.random((15, 10))
    beta = association_probabilities(L, np.ones((15, 10), bool), 0.9, 0.1)
    # A second implementation; enumeration would need some 1e10 events.
    slow = jpda._logarithmic(L, np.full(15, 0.1), np.full(10, 0.9))
    np.testing.assert_allclose(beta[1:], slow, atol=EXACT)


def test_a_perfect_lone_detection_under_the_printed_density() -> None:
    """C = 0.1 per px^2 is why thesis-literal freezes: the weight of a perfect hit is small."""
    for sd_px in (4.0, 5.0):
        peak = 1 / (2 * np.pi * sd_px**2)
        beta = association_probabilities([[peak]], [[True]], 0.9, 0.1)
        assert beta[1, 0] < 0.5
    assert association_probabilities([[1.0]], [[True]], 0.9, 0.1)[1, 0] > 0.98  # relative


def test_no_measurement_and_no_gate() -> None:
    none = association_probabilities(np.zeros((0, 3)), np.zeros((0, 3), bool), 0.9, 0.1)
    np.testing.assert_array_equal(none, np.ones((1, 3)))
    outside = association_probabilities(np.ones((2, 3)), np.zeros((2, 3), bool), 0.9, 0.0)
    np.testing.assert_array_equal(outside, [[1, 1, 1], [0, 0, 0], [0, 0, 0]])


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (([1.0], [True], 0.9, 0.1), r"shape \(m, T\), got \(1,\) and \(1,\)"),
        (([[1.0]], [[True, False]], 0.9, 0.1), r"got \(1, 1\) and \(1, 2\)"),
        (([[1.0]], [[True]], 1.5, 0.1), r"p_detect within 0..1, got 0.1 and \[1.5\]"),
        (([[1.0]], [[True]], 0.9, -0.1), "clutter must be at least 0"),
        (([[np.nan]], [[True]], 0.9, 0.1), "likelihood must be finite"),
        (([[-1.0]], [[True]], 0.9, 0.1), "likelihood must be finite and at least 0"),
        (([[1.0], [1.0]], [[True], [True]], 0.9, 0.0), "raise clutter above 0"),
        ((np.ones((1, 21)), np.ones((1, 21), bool), 0.9, 0.1), "21 targets share measurements"),
    ],
)
def test_wrong_input_is_named(arguments, words) -> None:
    with pytest.raises(ValueError, match=words):
        association_probabilities(*arguments)


def test_a_target_outside_every_gate_may_have_any_likelihood() -> None:
    beta = association_probabilities([[0.5, np.nan]], [[True, False]], 0.9, 0.1)
    np.testing.assert_allclose(beta[:, 1], [1.0, 0.0])
