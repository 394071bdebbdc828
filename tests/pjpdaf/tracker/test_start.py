"""First labels: who is the head, which hand is which, and when to wait."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from strategies import START_W, camera_at, detections, rig

from pjpdaf.camera import project, triangulate
from pjpdaf.interfaces import Detections
from pjpdaf.tracker.start import StartParameters, find_head_and_hands, head_of, locate

CAMERAS = rig().cameras
P = StartParameters()
AREAS = np.array([4500.0, 1500.0, 1400.0])


def look(
    points: np.ndarray, areas: np.ndarray = AREAS, order: list[int] | None = None
) -> tuple[Detections, ...]:
    order = order or list(range(len(points)))
    return tuple(detections(project(c, points)[order], areas[order]) for c in CAMERAS)


@pytest.mark.parametrize("order", [[0, 1, 2], [2, 1, 0], [1, 2, 0]])
def test_head_right_hand_left_hand(order: list[int]) -> None:
    positions_m = find_head_and_hands(CAMERAS, look(START_W, order=order), P)
    np.testing.assert_allclose(positions_m, START_W, atol=1e-9)
    # The person faces the cameras: the right hand is left in both pictures.
    for camera in CAMERAS:
        assert project(camera, positions_m[1])[0] < project(camera, positions_m[2])[0]


def test_a_false_blob_does_not_become_a_hand() -> None:
    false = np.array([[0.0, 0.35, 0.7], [0.1, -0.4, 0.9]])
    seen = look(np.vstack([START_W, false]), np.array([4500.0, 1500, 1400, 300, 200]))
    np.testing.assert_allclose(find_head_and_hands(CAMERAS, seen, P), START_W, atol=1e-9)


def test_a_blob_in_one_view_only_is_not_used() -> None:
    left, right = look(START_W)
    extra = detections(
        np.vstack([left.centres_px, [[100.0, 470.0]]]), np.append(left.areas_px, 9000.0)
    )
    np.testing.assert_allclose(find_head_and_hands(CAMERAS, (extra, right), P), START_W, atol=1e-9)


def test_waits_for_a_frame_on_which_the_views_agree() -> None:
    left, right = look(START_W)
    assert find_head_and_hands(CAMERAS, (left, Detections.none()), P) is None
    assert find_head_and_hands(CAMERAS, (left, Detections.none(missing=True)), P) is None
    hidden = detections(right.centres_px[:2], right.areas_px[:2])
    assert find_head_and_hands(CAMERAS, (left, hidden), P) is None
    # A hand half hidden in one view: its centre is 30 px off the epipolar line.
    off = right.centres_px + np.array([[0, 0], [0, 30], [0, 0]])
    assert find_head_and_hands(CAMERAS, (left, detections(off, AREAS)), P) is None
    # Left and right views the wrong way round: points behind the cameras.
    assert find_head_and_hands(CAMERAS, (right, left), P) is None
    # One camera has no depth.
    assert find_head_and_hands(CAMERAS[:1], (left,), P) is None


def test_far_away_blobs_are_no_hands() -> None:
    far = START_W.copy()
    far[1] = [-3.0, -0.6, 0.4]
    assert find_head_and_hands(CAMERAS, look(far), P) is None


def test_one_hand_twice_is_not_two_hands() -> None:
    same = START_W.copy()
    same[2] = same[1]
    assert find_head_and_hands(CAMERAS, look(same), P) is None


def test_three_views() -> None:
    cameras = (*CAMERAS, camera_at(0.3))
    seen = tuple(detections(project(c, START_W), AREAS) for c in cameras)
    np.testing.assert_allclose(find_head_and_hands(cameras, seen, P), START_W, atol=1e-9)


def test_head_is_the_largest_area_that_has_two_below() -> None:
    view = detections(
        [[300, 100], [310, 60], [200, 300], [400, 300]], np.array([4500.0, 400, 6000, 900])
    )
    assert head_of(view) == 0
    assert head_of(detections([[300, 100], [200, 300]])) is None


def test_triangulation_equals_opencv() -> None:
    rng = np.random.default_rng(45)
    for point in START_W:
        pixels = np.array([project(c, point) for c in CAMERAS]) + rng.normal(0, 1, (2, 2))
        x = cv2.triangulatePoints(CAMERAS[0].M, CAMERAS[1].M, *pixels.reshape(2, 2, 1))
        theirs = (x[:3] / x[3]).ravel()
        # Not bitwise: rows are scaled differently, which weighs the noise differently.
        np.testing.assert_allclose(triangulate(CAMERAS, pixels), theirs, atol=2e-3)
        exact = np.array([project(c, point) for c in CAMERAS])
        x = cv2.triangulatePoints(CAMERAS[0].M, CAMERAS[1].M, *exact.reshape(2, 2, 1))
        np.testing.assert_allclose((x[:3] / x[3]).ravel(), point, atol=1e-9)
        np.testing.assert_allclose(triangulate(CAMERAS, exact), point, atol=1e-9)
        np.testing.assert_allclose(locate(CAMERAS, exact, P), point, atol=1e-9)


def test_parallel_rays_have_no_point() -> None:
    K = CAMERAS[0].K
    centre = np.tile(K[:2, 2], (2, 1))
    assert np.all(np.isnan(triangulate(CAMERAS, centre)))
    assert locate(CAMERAS, centre, P) is None


def test_an_arm_cut_in_two_does_not_become_both_hands() -> None:
    """A watch or a rolled sleeve; the other hand is the smallest blob of the three."""
    forearm = START_W[2] + np.array([-0.05, 0.15, -0.12])
    seen = look(np.vstack([START_W, forearm]), np.array([4500.0, 900, 1500, 1600]))
    positions_m = find_head_and_hands(CAMERAS, seen, P)
    np.testing.assert_allclose(positions_m[:2], START_W[:2], atol=1e-9)
