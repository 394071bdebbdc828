"""Detections of another detector, looked up by frame."""

import numpy as np
import pytest

from pjpdaf.camera import Camera, distort_points
from pjpdaf.detector.external import (
    HAND_AREA_M2,
    HEAD_AREA_M2,
    USUAL_DEPTH_M,
    DetectionTable,
    ExternalDetector,
)
from pjpdaf.frames import StereoFrame

K = np.array([[540.0, 0.0, 319.5], [0.0, 540.0, 239.5], [0.0, 0.0, 1.0]])
LENS = np.array([-0.15, 0.03, 0.0, 0.0, 0.0])
PICTURE = np.zeros((480, 640, 3), np.uint8)


def camera(distortion=()):
    return Camera(K, np.eye(3), np.zeros(3), 640, 480, np.array(distortion))


def table(frames, centres_px, evidence=None, areas_px=None):
    n = len(frames)
    return DetectionTable(
        np.array(frames, np.intp),
        np.array(centres_px, float).reshape(n, 2),
        np.full(n, 2.0),
        np.full(n, np.nan) if areas_px is None else np.array(areas_px, float),
        evidence,
    )


def detector(left, right=None, distortion=()):
    one = camera(distortion)
    return ExternalDetector((one, one), (left, DetectionTable.empty() if right is None else right))


def test_a_frame_gets_its_rows_and_no_others():
    found = detector(table([0, 2, 2, 5], [[1, 2], [3, 4], [5, 6], [7, 8]]))
    counts = [len(found(StereoFrame(i, i / 3, (PICTURE, PICTURE)))[0]) for i in range(7)]
    assert counts == [1, 0, 2, 0, 0, 1, 0]
    left, right = found(StereoFrame(2, 2 / 3, (PICTURE, PICTURE)))
    np.testing.assert_array_equal(left.centres_px, [[3, 4], [5, 6]])
    np.testing.assert_array_equal(left.covariances_px2, np.tile(4 * np.eye(2), (2, 1, 1)))
    assert len(right) == 0
    assert not right.missing


def test_a_picture_that_did_not_arrive_is_missing():
    left, right = detector(table([0], [[1, 2]]))(StereoFrame(0, 0.0, (None, PICTURE)))
    assert left.missing
    assert not right.missing


def test_the_lens_is_taken_out_of_pixels_as_filmed():
    ideal = np.array([[80.0, 60.0], [320.0, 240.0], [600.0, 420.0]])
    filmed = distort_points(camera(LENS), ideal)
    assert np.abs(filmed - ideal).max() > 5
    found = detector(table([0, 0, 0], filmed), distortion=LENS)
    left, _ = found(StereoFrame(0, 0.0, (PICTURE, PICTURE)))
    np.testing.assert_allclose(left.centres_px, ideal, atol=1e-6)


def test_areas_that_are_not_given_are_usual_for_the_likeliest_target():
    evidence = np.array([[0.0, -3.0, -3.0], [-3.0, 0.0, -3.0], [0.0, 0.0, 0.0]])
    areas = [np.nan, np.nan, 777.0]
    found = detector(table([0, 0, 0], [[1, 2], [3, 4], [5, 6]], evidence, areas))
    left, _ = found(StereoFrame(0, 0.0, (PICTURE, PICTURE)))
    scale = (540.0 / USUAL_DEPTH_M) ** 2
    np.testing.assert_allclose(left.areas_px, [HEAD_AREA_M2 * scale, HAND_AREA_M2 * scale, 777.0])
    np.testing.assert_array_equal(left.evidence, evidence)
    # Discs of that area.
    np.testing.assert_allclose(np.pi * left.ellipses[:, 2] * left.ellipses[:, 3], left.areas_px)


def test_a_table_that_is_not_sorted_is_refused():
    with pytest.raises(ValueError, match="must be sorted"):
        table([1, 0], [[1, 2], [3, 4]])
