"""Two-view geometry of many points beside that of one."""

from __future__ import annotations

import numpy as np

from pjpdaf.camera import project, projection_jacobian
from pjpdaf.tracker.hypotheses.geometry import Views, stereo_information
from tests.strategies import rig

CAMERAS = rig().cameras
VIEWS = Views.of(CAMERAS)
POINTS = np.array([[0.0, 0.0, 1.2], [0.3, -0.2, 0.9], [0.4, 0.25, 0.85]])


def test_projection_and_jacobian_are_those_of_the_cameras():
    pixels, _ = VIEWS.project(POINTS)
    H = VIEWS.jacobians(POINTS)
    for view, camera in enumerate(CAMERAS):
        np.testing.assert_allclose(pixels[view], project(camera, POINTS), atol=1e-9)
        for point, slope in zip(POINTS, H[:, view], strict=True):
            np.testing.assert_allclose(slope, projection_jacobian(camera, point), atol=1e-9)


def test_triangulation_returns_the_points():
    pixels, _ = VIEWS.project(POINTS)
    points, residual = VIEWS.triangulate(pixels[0], pixels[1])
    np.testing.assert_allclose(points, POINTS, atol=1e-9)
    assert residual.max() < 1e-6


def test_views_that_disagree_have_a_residual():
    pixels, _ = VIEWS.project(POINTS)
    _, residual = VIEWS.triangulate(pixels[0], pixels[1] + (0.0, 10.0))
    assert residual.min() > 2.0


def test_information_is_that_of_the_full_noise_matrix():
    H = VIEWS.jacobians(POINTS)
    found = stereo_information(H, np.full(3, 2.5), np.full(3, 0.7))
    R = np.kron(np.full((2, 2), 2.5**2) + np.eye(2) * 0.7**2, np.eye(2))
    for slope, information in zip(H, found, strict=True):
        stacked = slope.reshape(4, 3)
        expected = stacked.T @ np.linalg.solve(R, stacked)
        np.testing.assert_allclose(information, expected, rtol=1e-9, atol=1e-9)


def test_common_error_says_nothing_against_the_depth():
    H = VIEWS.jacobians(POINTS[:1])
    depth = VIEWS.axes[2]
    sd = []
    for common in (0.5, 8.0):
        information = stereo_information(H, np.array([common]), np.array([0.7]))[0]
        sd.append(np.sqrt(depth @ np.linalg.inv(information) @ depth))
    assert sd[1] < 1.2 * sd[0]
