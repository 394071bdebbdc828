"""Blobs: moments of drawn shapes, Eq. 3.1-3.2, hypotheses, fragments, undistortion."""

from __future__ import annotations

import math

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pjpdaf.camera import Camera, undistort_points
from pjpdaf.detector.blobs import (
    Moments,
    Segments,
    clean,
    cluster,
    ellipse_axes,
    ellipse_error,
    moments,
    segments,
    undistort_moments,
)

SIZE = (480, 640)
Ellipse = tuple[float, float, float, float, float]  # centre x, y, semi-axes a, b, angle [rad]


def drawn(*ellipses: Ellipse, size: tuple[int, int] = SIZE) -> np.ndarray:
    """Mask with the pixels whose centres lie in an ellipse: exact, unlike cv2.ellipse."""
    y, x = np.mgrid[0 : size[0], 0 : size[1]]
    mask = np.zeros(size, bool)
    for cx, cy, a, b, angle in ellipses:
        u = (x - cx) * math.cos(angle) + (y - cy) * math.sin(angle)
        v = -(x - cx) * math.sin(angle) + (y - cy) * math.cos(angle)
        mask |= (u / a) ** 2 + (v / b) ** 2 <= 1
    return mask.astype(np.uint8) * 255


def found(mask: np.ndarray, **options) -> Moments:
    seen = segments(mask, 150, True)
    labels = cluster(seen, **options)
    return moments(seen.points, labels, int(labels.max()) + 1)


HEAD = (310.3, 105.6, 45.0, 34.0, 1.5)
HANDS = ((150.2, 330.9, 27.0, 17.0, 0.6), (470.7, 345.1, 24.0, 16.0, -0.9))


@settings(max_examples=40, deadline=None)
@given(
    st.floats(80, 500),
    st.floats(80, 400),
    st.floats(28, 60),
    st.floats(0.5, 0.9),
    st.floats(-1.5, 1.5),
)
def test_an_ellipse_is_recovered(x, y, a, ratio, angle):
    seen = segments(drawn((x, y, a, ratio * a, angle)), 100, False)
    fit = moments(seen.points, seen.component, 1)
    (got,) = ellipse_axes(fit)
    # Drawing in whole pixels moves the centre by hundredths of a pixel, and by 0.13 px where all
    # rows are rounded the same way (upright, centre on a row): found by hypothesis.
    np.testing.assert_allclose(got[:2], (x, y), atol=0.2)
    np.testing.assert_allclose(got[2:4], (a, ratio * a), rtol=0.02)
    assert abs(math.sin(got[4] - angle)) < 0.05
    assert fit.areas[0] == pytest.approx(math.pi * a * a * ratio, rel=0.02)


def test_centres_of_tilted_ellipses_are_right_to_a_tenth_of_a_pixel():
    rng = np.random.default_rng(12)
    for _ in range(50):
        x, y, a = rng.uniform(80, 400), rng.uniform(80, 400), rng.uniform(20, 60)
        seen = segments(drawn((x, y, a, 0.7 * a, rng.uniform(0.1, 1.4))), 100, False)
        centre = moments(seen.points, seen.component, 1).centres[0]
        np.testing.assert_allclose(centre, (x, y), atol=0.1)


def test_moments_of_a_lattice_are_those_of_all_pixels():
    seen = segments(drawn(HEAD), 100, False)
    whole = moments(seen.points, seen.component, 1)
    on = (seen.points % 4 == 0).all(axis=1)
    some = moments(seen.points[on], seen.component[on], 1, 4)
    np.testing.assert_allclose(some.centres, whole.centres, atol=0.3)
    np.testing.assert_allclose(some.covariances, whole.covariances, rtol=0.03, atol=10)
    assert some.areas[0] == pytest.approx(whole.areas[0], rel=0.02)


def test_a_square_by_hand():
    """5 x 5 pixels: variance of a square of side 5 is 25 / 12."""
    mask = np.zeros((20, 20), np.uint8)
    mask[4:9, 10:15] = 255
    seen = segments(mask, 1, False)
    fit = moments(seen.points, seen.component, 1)
    np.testing.assert_array_equal(fit.centres, [[12, 6]])
    np.testing.assert_allclose(fit.covariances, [25 / 12 * np.eye(2)])
    assert fit.areas.tolist() == [25.0]


def brute_error(points, labels, fit: Moments, size, step) -> int:
    """Eq. 3.1 by visiting every pixel of the lattice for every cluster."""
    y, x = np.mgrid[0 : size[0] : step, 0 : size[1] : step]
    err = 0
    for k in range(len(fit)):
        own = np.zeros(size, bool)
        mine = points[labels == k]
        own[mine[:, 1], mine[:, 0]] = True
        d = np.stack([x, y], -1) - fit.centres[k]
        inside = np.einsum("...i,ij,...j", d, np.linalg.inv(fit.covariances[k]), d) <= 4
        own = own[::step, ::step]
        err += int((own & ~inside).sum() + (inside & ~own).sum())
    return err


@pytest.mark.parametrize("step", [1, 3, 4])
@pytest.mark.parametrize(
    "shapes",
    [
        (HEAD, *HANDS),
        ((0.0, 200.0, 40.0, 30.0, 0.3), (638.0, 478.0, 50.0, 20.0, 1.0)),  # cut by the border
        ((300.0, 200.0, 60.0, 9.0, 0.8), (330.0, 230.0, 50.0, 9.0, -0.7)),  # a cross
    ],
)
def test_error_counts_as_the_slow_way(shapes, step):
    seen = segments(drawn(*shapes), 50, False)
    on = (seen.points % step == 0).all(axis=1)
    points = seen.points[on]
    for labels in (seen.component[on], (points[:, 0] > points[:, 0].mean()).astype(int)):
        fit = moments(points, labels, int(labels.max()) + 1, step)
        fast = ellipse_error(points, labels, fit, SIZE, step)
        assert fast == brute_error(points, labels, fit, SIZE, step)


def test_an_ellipse_has_nearly_no_error_and_two_as_one_have_much():
    seen = segments(drawn(HEAD, HANDS[0]), 100, False)
    each = moments(seen.points, seen.component, 2)
    assert ellipse_error(seen.points, seen.component, each, SIZE) < 0.02 * len(seen.points)
    one = np.zeros(len(seen.points), np.intp)
    both = moments(seen.points, one, 1)
    assert ellipse_error(seen.points, one, both, SIZE) > len(seen.points)


@pytest.mark.parametrize("compete", [False, True])
@pytest.mark.parametrize("subsample", [1, 16])
@pytest.mark.parametrize("n", [1, 2, 3])
def test_separate_blobs_are_counted(n, subsample, compete):
    shapes = (HEAD, *HANDS)[:n]
    fit = found(drawn(*shapes), subsample=subsample, components_compete=compete)
    assert len(fit) == n
    for shape in shapes:
        nearest = np.linalg.norm(fit.centres - shape[:2], axis=1).min()
        assert nearest < 0.1


def test_merged_hands_are_split_in_two():
    """What the thesis's hypotheses are for (Fig. 3.6): two crossing hands are one component."""
    shapes = ((250.0, 300.0, 34.0, 14.0, 0.0), (305.0, 300.0, 34.0, 14.0, 0.2), HEAD)
    mask = drawn(*shapes)
    assert segments(mask, 150, True).count == 2
    fit = found(mask)
    assert len(fit) == 3
    for shape in shapes:
        assert np.linalg.norm(fit.centres - shape[:2], axis=1).min() < 6


def test_a_hand_by_the_head_keeps_its_pixels():
    """k-means alone gives the head's rim to the hand, so that the head is cut up; the components,
    competing, stay whole.
    """
    hand = (310.3, 105.6 + 45 + 15 + 18, 22.0, 18.0, 0.0)
    mask = drawn(HEAD, hand, HANDS[0])
    fit = found(mask, subsample=16, components_compete=True)
    assert len(fit) == 3
    assert np.linalg.norm(fit.centres - hand[:2], axis=1).min() < 0.1
    alone = found(mask, subsample=16, components_compete=False)
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


def test_one_pixel_in_16_gives_the_same_answer():
    rng = np.random.default_rng(11)
    same = 0
    scenes = 50
    for _ in range(scenes):
        seen = segments(drawn(*random_scene(rng)), 150, True)
        labels = [cluster(seen, subsample=n, components_compete=False) for n in (1, 16)]
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
    first = cluster(seen, subsample=16)
    cv2.setRNGSeed(99)
    cv2.kmeans(np.float32(np.random.default_rng(0).random((50, 2))), 3, None, (3, 9, 0), 2, 2)
    assert cluster(seen, subsample=16).tobytes() == first.tobytes()
    threads = cv2.getNumThreads()
    try:
        for n in (1, 3):
            cv2.setNumThreads(n)
            assert cluster(seen, subsample=16).tobytes() == first.tobytes()
    finally:
        cv2.setNumThreads(threads)


def test_a_crowd_of_blobs_is_reported_as_it_is_and_quickly():
    grid = [(x, y, 9.0, 9.0, 0.0) for x in range(20, 620, 30) for y in range(20, 460, 30)]
    seen = segments(drawn(*grid), 50, False)
    assert seen.count == len(grid)
    assert cluster(seen) is seen.component


def test_nothing_gives_nothing():
    seen = segments(np.zeros(SIZE, np.uint8), 10, True)
    assert seen.count == 0
    assert len(cluster(seen)) == 0
    only_small = segments(drawn((50, 50, 3, 3, 0)), 100, True)
    assert only_small.count == 0
    assert len(only_small.points) == 0


def test_opening_removes_specks_and_closing_fills_holes():
    mask = drawn(HEAD)
    mask[100, 310] = 0
    mask[300, 300] = 255
    tidy = clean(mask, 3, 5)
    assert tidy[100, 310] == 255
    assert tidy[300, 300] == 0
    assert clean(mask, 0, 0) is mask
    only_open = clean(mask, 3, 0)
    np.testing.assert_array_equal(only_open & ~mask, 0)  # opening only takes away
    np.testing.assert_array_equal(mask & ~clean(mask, 0, 5), 0)  # closing only adds


def test_fragments_join_their_nearest_and_never_bridge_two_large_ones():
    mask = np.zeros(SIZE, np.uint8)
    mask[100:140, 100:140] = 255  # large
    mask[100:108, 142:150] = 255  # fragment 2 px from it
    mask[100:140, 155:195] = 255  # large, 5 px from the fragment
    mask[300:308, 300:310] = 255  # two fragments that only together are large enough
    mask[310:318, 300:310] = 255
    mask[400:408, 400:408] = 255  # alone and too small
    joined = segments(mask, 150, True)
    areas = sorted(np.bincount(joined.component).tolist())
    assert areas == [160, 1600, 1664]
    plain = segments(mask, 150, False)
    assert sorted(np.bincount(plain.component).tolist()) == [1600, 1600]


def test_fragments_that_point_at_each_other_end():
    mask = np.zeros((60, 60), np.uint8)
    for x in (10, 14, 18):
        mask[20:23, x : x + 3] = 255
    assert segments(mask, 20, True).count == 1
    assert segments(mask, 28, True).count == 0


def test_a_thick_lattice_is_thinned_until_every_blob_has_pixels():
    tiny = drawn(HEAD, (50.0, 400.0, 2.0, 2.0, 0.0))
    seen = segments(tiny, 5, False)
    assert seen.count == 2
    fit = found(tiny, subsample=400)
    assert len(fit) >= 1


@pytest.mark.parametrize("lens", [[-0.25, 0.08, 0.001, -0.001, 0.0], [0.15, -0.1, 0, 0, 0]])
def test_undistorted_ellipses_are_those_of_undistorted_pixels(lens):
    K = np.array([[520.0, 0, 319.5], [0, 520.0, 239.5], [0, 0, 1]])
    camera = Camera(K, np.eye(3), np.zeros(3), 640, 480, np.array(lens, float))
    for shape in ((80.0, 80.0, 45.0, 33.0, 0.7), HEAD, HANDS[1]):
        seen = segments(drawn(shape), 100, False)
        fit = undistort_moments(camera, moments(seen.points, seen.component, 1))
        # The slow way: every pixel moved, weighted with its new area.
        at, half_x, half_y = seen.points, np.array([0.5, 0]), np.array([0, 0.5])
        ideal = undistort_points(camera, at)
        right = undistort_points(camera, at + half_x)
        left = undistort_points(camera, at - half_x)
        down = undistort_points(camera, at + half_y)
        up = undistort_points(camera, at - half_y)
        u, v = right - left, down - up
        area = np.abs(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])
        centre = np.average(ideal, axis=0, weights=area)
        d = ideal - centre
        np.testing.assert_allclose(fit.centres[0], centre, atol=0.02)
        covariance = np.einsum("n,ni,nj", area, d, d) / area.sum()
        np.testing.assert_allclose(fit.covariances[0], covariance, rtol=0.01, atol=1)
        assert fit.areas[0] == pytest.approx(area.sum(), rel=0.02)


def test_no_distortion_changes_nothing():
    fit = found(drawn(HEAD))
    camera = Camera(np.eye(3) * [[500], [500], [1]], np.eye(3), np.zeros(3), 640, 480)
    assert undistort_moments(camera, fit) is fit


def test_axes_are_sorted_and_angles_in_range():
    for angle in np.linspace(-1.57, 1.57, 23):
        c, s = math.cos(angle), math.sin(angle)
        R = np.array([[c, -s], [s, c]])
        fit = Moments(np.zeros((1, 2)), (R @ np.diag([9.0, 4.0]) @ R.T)[None], np.ones(1))
        (x, y, a, b, got) = ellipse_axes(fit)[0]
        assert (x, y) == (0, 0)
        assert (a, b) == pytest.approx((6, 4))
        assert -math.pi / 2 < got <= math.pi / 2
        assert abs(math.sin(got - angle)) < 1e-9


def test_segments_are_a_plain_record():
    seen = segments(drawn(HEAD, size=(200, 400)), 100, False)
    assert isinstance(seen, Segments)
    assert seen.size == (200, 400)
    mask = np.zeros(seen.size, np.uint8)
    mask[seen.points[:, 1], seen.points[:, 0]] = 255
    np.testing.assert_array_equal(mask, drawn(HEAD, size=(200, 400)))
