"""Rotation between the views that a calibration missed."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from pjpdaf.camera import Camera
from pjpdaf.detector.alignment import align, align_points, moved

K = np.array([[540.0, 0, 319.5], [0, 540.0, 239.5], [0, 0, 1]])
LEFT = Camera(K, np.eye(3), np.zeros(3), 640, 480)
RIGHT = Camera(K, np.eye(3), np.array([-0.09, 0.0, 0.0]), 640, 480)
ROTATIONS_DEG = [
    (0.0, 0.5, 0.0),
    (0.0, -1.0, 0.0),
    (0.8, 0.0, 0.0),
    (0.0, 0.0, 0.6),
    (0.3, -0.7, 0.2),
]


def points(turn_deg, count: int = 400) -> tuple[np.ndarray, np.ndarray]:
    """Pixels of points in a room; the right camera is turned against its calibration."""
    rng = np.random.default_rng(1)
    depth = rng.uniform(1.0, 3.5, count)
    pixels = rng.uniform((5, 5), (635, 475), (count, 2))
    X = np.column_stack([(pixels - K[:2, 2]) / 540.0, np.ones(count)]) * depth[:, None]
    R, _ = cv2.Rodrigues(np.radians(turn_deg))
    q = (X + RIGHT.t_cw) @ R @ K.T  # R.T X: the camera turned by R
    other = q[:, :2] / q[:, 2:]
    return pixels + rng.normal(0, 0.3, pixels.shape), other + rng.normal(0, 0.3, other.shape)


@pytest.mark.parametrize("turn_deg", ROTATIONS_DEG)
def test_points_show_the_rotation_within_the_stated_deviations(turn_deg):
    one, two = points(turn_deg)
    wrong = np.arange(len(two)) % 5 == 0
    two[wrong] += np.random.default_rng(2).uniform(-10, 10, (wrong.sum(), 2))
    found = align_points(one, two, (LEFT, RIGHT))
    assert found is not None
    assert found.matters
    assert np.abs(np.degrees(found.rotation) - turn_deg).max() < 0.12
    assert (np.abs(found.rotation - np.radians(turn_deg)) < 3 * found.deviations).all()


def test_a_good_calibration_is_left_alone():
    found = align_points(*points((0, 0, 0)), (LEFT, RIGHT))
    assert found is not None
    assert not found.matters


def test_taking_the_rotation_out_restores_the_calibrations_pixels():
    one, two = points((0.3, -0.7, 0.2))
    found = align_points(one, two, (LEFT, RIGHT))
    _, straight = points((0, 0, 0))
    assert found is not None
    before = np.abs(two - straight).mean()
    after = np.abs(moved(two, found.homography(RIGHT)) - straight).mean()
    assert before > 4
    assert after < 1


def test_few_points_or_points_in_one_corner_say_nothing():
    one, two = points((0, 0.5, 0))
    assert align_points(one[:30], two[:30], (LEFT, RIGHT)) is None
    corner = (two < (200, 480)).all(axis=1)
    assert align_points(one[corner], two[corner], (LEFT, RIGHT)) is None
    assert moved(np.zeros((0, 2)), np.eye(3)).shape == (0, 2)


def test_pictures_of_a_wall_show_it_too():
    rng = np.random.default_rng(3)
    small = rng.uniform(40, 215, (80, 106, 3)).astype(np.float32)
    wall = cv2.resize(small, (848, 640), interpolation=cv2.INTER_CUBIC)
    wall = np.clip(wall, 0, 255).astype(np.uint8)
    place = np.array([[1.0, 0, -100], [0, 1, -80], [0, 0, 1]])
    shift = np.array([[1.0, 0, -0.09 * 540 / 2.0], [0, 1, 0], [0, 0, 1]])  # 2 m away
    R, _ = cv2.Rodrigues(np.radians((0.0, 0.6, 0.0)))
    turn = K @ R.T @ np.linalg.inv(K)
    left = cv2.warpPerspective(wall, place, (640, 480), flags=cv2.INTER_CUBIC)
    right = cv2.warpPerspective(wall, turn @ shift @ place, (640, 480), flags=cv2.INTER_CUBIC)
    found = align((left, right), (LEFT, RIGHT))
    assert found is not None
    np.testing.assert_allclose(np.degrees(found.rotation), (0, 0.6, 0), atol=0.1)
    grey = np.full((480, 640, 3), 120, np.uint8)
    assert align((grey, grey), (LEFT, RIGHT)) is None
