"""Clusters of skin pixels: k-means hypotheses and the best of them (thesis 3.1.2)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np

from pjpdaf.arrays import Bools, Floats, Ints
from pjpdaf.checks import AboveZero, AboveZeroInt, NotNegativeInt, check_bounds
from pjpdaf.detector.components import Segments
from pjpdaf.detector.ellipses import ellipse_error, moments

# Beyond this many components the hypotheses 1 .. N + 2 cost seconds and the scene is not three
# targets: the components themselves are reported.
COMPONENTS_MAX = 16
SAMPLE_MIN_PX = 400  # k-means never gets fewer pixels than this, for any `subsample`
KMEANS_SEED = 20090701  # fixed: the same picture gives the same bytes
KMEANS_STOP = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 30, 0.02)  # rounds, px
KMEANS_ATTEMPTS = 3


@dataclass(frozen=True)
class ClusterParameters:
    """Hypotheses of k clusters, and their choice."""

    # p of Eq. 3.2, Err (1 + k / p) [1], Table 4.1.
    kmeans_penalty: AboveZero = 5.0
    # Hypotheses k = 1 .. N + extra_hypotheses clusters for N components, section 3.1.2.
    extra_hypotheses: NotNegativeInt = 2
    # k-means sees every n-th skin pixel, on a square lattice [1]; 1 = all, as in the thesis.
    subsample: AboveZeroInt = 16
    # The N components themselves compete, beside k-means with k = N: k-means alone gives the rim of
    # a head to a hand close by. Not in the thesis.
    components_compete: bool = True

    def __post_init__(self) -> None:
        check_bounds("DetectorParameters", self)


def cluster(seen: Segments, parameters: ClusterParameters) -> Ints:
    """Return the best clustering of the skin pixels: a label (n,) in 0..k-1 for each point.

    The hypothesis with the smallest Err (1 + k / p) wins (Eq. 3.2), the smaller k where two are
    equal.
    """
    N, penalty = seen.count, parameters.kmeans_penalty
    if N == 0 or N > COMPONENTS_MAX:
        return seen.component
    step, chosen = lattice(seen, parameters.subsample)
    points, component = seen.points[chosen], seen.component[chosen]
    samples = points.astype(np.float32)
    best_err, best_centres = math.inf, None
    for k in range(1, min(N + parameters.extra_hypotheses, len(points)) + 1):
        labels, centres = kmeans(samples, k)
        err = ellipse_error(points, labels, moments(points, labels, k, step), seen.size, step)
        if err * (1 + k / penalty) < best_err:
            best_err, best_centres = err * (1 + k / penalty), centres
    if parameters.components_compete:
        fit = moments(points, component, N, step)
        err = ellipse_error(points, component, fit, seen.size, step)
        if err * (1 + N / penalty) <= best_err:
            return seen.component
    assert best_centres is not None
    return nearest_centre(seen.points, best_centres)


def lattice(seen: Segments, subsample: int) -> tuple[int, Bools | slice]:
    """Step of the sampling lattice [px] and which points lie on it.

    Every component must leave a few points, and all together SAMPLE_MIN_PX.
    """
    step = max(1, round(math.sqrt(subsample)))
    while step > 1:
        on = (seen.points[:, 0] % step == 0) & (seen.points[:, 1] % step == 0)
        each = np.bincount(seen.component[on], minlength=seen.count)
        if int(on.sum()) >= SAMPLE_MIN_PX and each.min() >= 3:
            return step, on
        step -= 1
    return 1, slice(None)


def kmeans(samples: np.ndarray, k: int) -> tuple[Ints, Floats]:
    """Labels (n,) and centres (k, 2) of float32 samples (n, 2); the same for the same samples."""
    cv2.setRNGSeed(KMEANS_SEED)
    _, labels, centres = cv2.kmeans(
        samples, k, None, KMEANS_STOP, KMEANS_ATTEMPTS, cv2.KMEANS_PP_CENTERS
    )
    return labels.ravel().astype(np.intp), np.asarray(centres, dtype=np.float64)


def nearest_centre(points: Ints, centres: Floats) -> Ints:
    """Index of the nearest centre for each point (n, 2)."""
    x, y = (points[:, axis] - centres[:, axis, None] for axis in (0, 1))
    nearest: Ints = np.argmin(x * x + y * y, axis=0)
    return nearest
