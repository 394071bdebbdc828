"""Cameras against OpenCV."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from strategies import START_W, camera_at, rig

from pjpdaf.camera import (
    Camera,
    StereoRig,
    distort_points,
    project,
    to_camera,
    triangulate,
    undistort_picture,
    undistort_points,
)

LENS = np.array([-0.28, 0.09, 0.0008, -0.0005, -0.01])


def bent() -> Camera:
    camera = camera_at(0.0)
    return Camera(camera.K, camera.R_cw, camera.t_cw, 640, 480, LENS)


def turned() -> Camera:
    R = cv2.Rodrigues(np.array([[0.1], [-0.2], [0.05]]))[0]
    camera = camera_at(0.1)
    return Camera(camera.K, R @ camera.R_cw, R @ camera.t_cw, 640, 480)


def test_projection_equals_opencv() -> None:
    for camera in (camera_at(0.0), turned()):
        rotation = cv2.Rodrigues(np.array(camera.R_cw))[0]
        theirs, _ = cv2.projectPoints(
            START_W, rotation, np.array(camera.t_cw).reshape(3, 1), np.array(camera.K), np.zeros(5)
        )
        np.testing.assert_allclose(project(camera, START_W), theirs.reshape(-1, 2), atol=1e-9)
        q = camera.M @ np.append(START_W[1], 1.0)
        np.testing.assert_allclose(q[:2] / q[2], project(camera, START_W[1]))
        np.testing.assert_allclose(to_camera(camera, camera.centre_w), 0.0, atol=1e-12)


def test_pixel_zero_is_the_centre_of_the_top_left_pixel() -> None:
    camera = camera_at(0.0)
    ahead = camera.centre_w + camera.R_cw.T @ [0, 0, 2.0]
    np.testing.assert_allclose(project(camera, ahead), [319.5, 239.5])


def test_behind_is_not_a_number() -> None:
    assert np.all(np.isnan(project(camera_at(0.0), np.array([[9.0, 0, 1], [1.3, 0, 1]]))))


@given(st.floats(0, 639), st.floats(0, 479))
def test_lens_there_and_back(x: float, y: float) -> None:
    camera = bent()
    back = distort_points(camera, undistort_points(camera, np.array([[x, y]])))
    np.testing.assert_allclose(back, [[x, y]], atol=1e-3)


def test_distortion_equals_opencv() -> None:
    camera = bent()
    rotation = cv2.Rodrigues(np.array(camera.R_cw))[0]
    theirs, _ = cv2.projectPoints(
        START_W, rotation, np.array(camera.t_cw).reshape(3, 1), np.array(camera.K), LENS
    )
    np.testing.assert_allclose(
        distort_points(camera, project(camera, START_W)), theirs.reshape(-1, 2), atol=1e-9
    )


def test_a_perfect_lens_changes_nothing() -> None:
    camera, pixels = camera_at(0.0), np.array([[1.5, 2.5]])
    np.testing.assert_array_equal(undistort_points(camera, pixels), pixels)
    np.testing.assert_array_equal(distort_points(camera, pixels), pixels)
    picture = np.zeros((480, 640, 3), np.uint8)
    assert undistort_picture(camera, picture) is picture
    assert undistort_points(bent(), np.zeros((0, 2))).shape == (0, 2)
    assert undistort_picture(bent(), picture).shape == picture.shape


def test_picture_and_points_are_undistorted_alike() -> None:
    camera = bent()
    picture = np.zeros((480, 640, 3), np.uint8)
    cv2.circle(picture, (120, 90), 6, (255, 255, 255), -1)
    ys, xs = np.nonzero(undistort_picture(camera, picture)[..., 0] > 127)
    ideal = undistort_points(camera, np.array([[120.0, 90.0]]))[0]
    # A filled circle of 13 px is drawn on whole pixels; its centre survives to a quarter pixel.
    np.testing.assert_allclose([xs.mean(), ys.mean()], ideal, atol=0.25)


def test_triangulation_of_two_to_four_views() -> None:
    cameras = (*rig().cameras, turned(), camera_at(0.5))
    for n in (2, 3, 4):
        pixels = np.array([project(c, START_W[2]) for c in cameras[:n]])
        np.testing.assert_allclose(triangulate(cameras[:n], pixels), START_W[2], atol=1e-9)


def test_rig_follows_opencvs_stereo_convention() -> None:
    pair = StereoRig(camera_at(-0.045), turned())
    X_left, X_right = to_camera(pair.left, START_W), to_camera(pair.right, START_W)
    np.testing.assert_allclose(X_left @ pair.R.T + pair.T, X_right, atol=1e-12)
    np.testing.assert_allclose(rig().T, [-0.09, 0, 0], atol=1e-12)
    assert pair.cameras == (pair.left, pair.right)


def test_records_are_read_only_copies() -> None:
    K = np.array(camera_at(0.0).K)
    camera = Camera(K, np.eye(3), np.zeros(3), 640, 480)
    K[0, 0] = 1.0
    assert camera.K[0, 0] == 540.0
    with pytest.raises(ValueError, match="read-only"):
        camera.K[0, 0] = 1.0


def test_wrong_shapes_are_named() -> None:
    with pytest.raises(ValueError, match=r"Camera.K must have shape \(3, 3\), got \(2, 2\)"):
        Camera(np.eye(2), np.eye(3), np.zeros(3), 640, 480)
    with pytest.raises(ValueError, match=r"Camera.t_cw must have shape \(3\), got \(3, 1\)"):
        Camera(np.eye(3), np.eye(3), np.zeros((3, 1)), 640, 480)
    with pytest.raises(ValueError, match=r"Camera\.distortion must have one of .* values, got 3"):
        Camera(np.eye(3), np.eye(3), np.zeros(3), 640, 480, np.zeros(3))


def test_many_points_are_triangulated_as_one_by_one() -> None:
    cameras = (*rig().cameras, turned())
    pixels = np.random.default_rng(0).uniform(100.0, 500.0, (3, 4, 2, 2))
    points = triangulate(cameras, pixels)
    assert points.shape == (4, 2, 3)
    for at in np.ndindex(4, 2):
        assert points[at].tobytes() == triangulate(cameras, pixels[:, *at]).tobytes()
