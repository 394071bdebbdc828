"""Clusters: hypotheses of k-means and of the components, their choice by Eq. 3.2."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from ellipse_masks import HANDS, HEAD, SIZE, Ellipse, drawn

from pjpdaf.detector.clusters import ClusterParameters, cluster
from pjpdaf.detector.components import Segments, segments
from pjpdaf.detector.ellipses import Moments, moments


def clustered(seen: Segments, **options):
    """Labels, of all pixels where no other subsample is given."""
    return cluster(seen, ClusterParameters(**({"subsample": 1} | options)))


def fit_clusters(mask: np.ndarray, **options) -> Moments:
    seen = segments(mask, 150, True)
    labels = clustered(seen, **options)
    return moments(seen.points, labels, int(labels.max()) + 1)


@pytest.mark.parametrize("compete", [False, True])
@pytest.mark.parametrize("subsample", [1, 16])
@pytest.mark.parametrize("n", [1, 2, 3])
def test_separate_blobs_are_counted(n, subsample, compete):
    shapes = (HEAD, *HANDS)[:n]
    fit = fit_clusters(drawn(*shapes), subsample=subsample, components_compete=compete)
    assert len(fit) == n
    for shape in shapes:
        nearest = np.linalg.norm(fit.centres - shape[:2], axis=1).min()
        assert nearest < 0.1


def test_merged_hands_are_split_in_two():
    """What the thesis's hypotheses are for (Fig. 3.6): two crossing hands are one component."""
    shapes = ((250.0, 300.0, 34.0, 14.0, 0.0), (305.0, 300.0, 34.0, 14.0, 0.2), HEAD)
    mask = drawn(*shapes)
    assert segments(mask, 150, True).count == 2
    fit = fit_clusters(mask)
    assert len(fit) == 3
    for shape in shapes:
        assert np.linalg.norm(fit.centres - shape[:2], axis=1).min() < 6


def test_a_hand_by_the_head_keeps_its_pixels():
    """k-means alone gives the head's rim to the hand, so that the head is cut up; the components,
    competing, stay whole.
    """
    hand = (310.3, 105.6 + 45 + 15 + 18, 22.0, 18.0, 0.0)
    mask = drawn(HEAD, hand, HANDS[0])
    fit = fit_clusters(mask, subsample=16, components_compete=True)
    assert len(fit) == 3
    assert np.linalg.norm(fit.centres - hand[:2], axis=1).min() < 0.1
    alone = fit_clusters(mask, subsample=16, components_compete=False)
    assert len(alone) != 3


def random_scene(rng: np.random.Generator) -> tuple[Ellipse, ...]:
    return (
        (
            rng.uniform(260, 370),
            rng.uniform(80, 140),
            rng.uniform(40, 50),
            rng.uniform(30, 37),
            1.5,
        ),
        *(
            (
                rng.uniform(low, low + 170),
                rng.uniform(240, 420),
                rng.uniform(20, 30),
                rng.uniform(14, 19),
                rng.uniform(-1.5, 1.5),
            )
            for low in (60, 400)
        ),
    )


@pytest.mark.long
def test_one_pixel_in_16_gives_the_same_answer():
    rng = np.random.default_rng(11)
    same = 0
    scenes = 50
    for _ in range(scenes):
        seen = segments(drawn(*random_scene(rng)), 150, True)
        labels = [clustered(seen, subsample=n, components_compete=False) for n in (1, 16)]
        fits = [moments(seen.points, x, int(x.max()) + 1) for x in labels]
        if len(fits[0]) == len(fits[1]):
            order = [np.lexsort(f.centres.T) for f in fits]
            gap = fits[0].centres[order[0]] - fits[1].centres[order[1]]
            same += bool(np.abs(gap).max() < 0.5)
    assert same >= 0.99 * scenes  # 500 of 500 when measured


def test_the_same_pixels_give_the_same_bytes():
    seen = segments(
        drawn((280.0, 250.0, 60.0, 30.0, 0.5), (330.0, 290.0, 40.0, 30.0, 0.0)), 1, True
    )
    first = clustered(seen, subsample=16)
    cv2.setRNGSeed(99)
    cv2.kmeans(np.float32(np.random.default_rng(0).random((50, 2))), 3, None, (3, 9, 0), 2, 2)
    assert clustered(seen, subsample=16).tobytes() == first.tobytes()
    threads = cv2.getNumThreads()
    try:
        for n in (1, 3):
            cv2.setNumThreads(n)
            assert clustered(seen, subsample=16).tobytes() == first.tobytes()
    finally:
        cv2.setNumThreads(threads)


def test_a_crowd_of_blobs_is_reported_as_it_is_and_quickly():
    grid = [(x, y, 9.0, 9.0, 0.0) for x in range(20, 620, 30) for y in range(20, 460, 30)]
    seen = segments(drawn(*grid), 50, False)
    assert seen.count == len(grid)
    assert clustered(seen) is seen.component


def test_nothing_gives_nothing():
    seen = segments(np.zeros(SIZE, np.uint8), 10, True)
    assert seen.count == 0
    assert len(clustered(seen)) == 0
    only_small = segments(drawn((50, 50, 3, 3, 0)), 100, True)
    assert only_small.count == 0
    assert len(only_small.points) == 0


def test_a_thick_lattice_is_thinned_until_every_blob_has_pixels():
    tiny = drawn(HEAD, (50.0, 400.0, 2.0, 2.0, 0.0))
    seen = segments(tiny, 5, False)
    assert seen.count == 2
    fit = fit_clusters(tiny, subsample=400)
    assert len(fit) >= 1
