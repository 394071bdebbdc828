"""Ellipses: moments of drawn shapes, Err of Eq. 3.1, undistortion."""

from __future__ import annotations

import math

import numpy as np
import pytest
from ellipse_masks import HANDS, HEAD, SIZE, drawn
from hypothesis import given, settings
from hypothesis import strategies as st

from pjpdaf.camera import Camera, undistort_points
from pjpdaf.detector.components import segments
from pjpdaf.detector.ellipses import (
    Moments,
    ellipse_axes,
    ellipse_error,
    moments,
    undistort_moments,
)


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
    seen = segments(drawn(HEAD), 100, False)
    fit = moments(seen.points, seen.component, 1)
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
