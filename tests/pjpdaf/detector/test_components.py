"""Components: opening and closing, fragments, the smallest area."""

from __future__ import annotations

import dataclasses

import cv2
import numpy as np
import pytest
from ellipse_masks import HEAD, SIZE, drawn

from pjpdaf.camera import Camera
from pjpdaf.detector.components import ComponentParameters, Segments, clean, min_area_px, segments
from pjpdaf.interfaces import Estimates

K = np.array([[540.0, 0, 319.5], [0, 540.0, 239.5], [0, 0, 1]])
CAMERA = Camera(K, np.eye(3), np.zeros(3), 640, 480)


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


@pytest.mark.parametrize("radius", [4, 5, 6, 7])
@pytest.mark.parametrize("mirrored", [False, True])
def test_of_two_neighbours_at_the_same_distance_the_first_gets_the_fragment(radius, mirrored):
    # The square root of 37 px^2; its last bit is of either kind, by the place in the picture.
    mask = np.zeros((121, 121), np.uint8)
    cv2.circle(mask, (60, 60), radius, 255, -1)
    fragment, edge = np.count_nonzero(mask), 60 + radius + 6
    mask[30:60, edge : edge + 20] = 255
    mask[edge : edge + 20, 30:60] = 255
    joined = segments(mask[:, ::-1].copy() if mirrored else mask, 300, True)
    areas = [np.count_nonzero(joined.component == joined.component[at]) for at in (0, -1)]
    assert areas == [600 + fragment, 600]


def test_fragments_that_point_at_each_other_end():
    mask = np.zeros((60, 60), np.uint8)
    for x in (10, 14, 18):
        mask[20:23, x : x + 3] = 255
    assert segments(mask, 20, True).count == 1
    assert segments(mask, 28, True).count == 0


def test_segments_are_a_plain_record():
    seen = segments(drawn(HEAD, size=(200, 400)), 100, False)
    assert isinstance(seen, Segments)
    assert seen.size == (200, 400)
    mask = np.zeros(seen.size, np.uint8)
    mask[seen.points[:, 1], seen.points[:, 0]] = 255
    np.testing.assert_array_equal(mask, drawn(HEAD, size=(200, 400)))


def test_the_least_area_goes_with_focal_length_and_depth():
    p = ComponentParameters(min_area_px=100.0, reference_focal_px=540.0, reference_depth_m=1.3)
    assert min_area_px(p, CAMERA, None) == pytest.approx(100)
    long = dataclasses.replace(CAMERA, K=np.diag([2.0, 2.0, 1.0]) @ K)
    assert min_area_px(p, long, None) == pytest.approx(400)
    at = np.array([[0, 0, 2.6]] * 3)
    seen = Estimates(at, np.zeros((3, 3, 3)), np.zeros((3, 3)), ("tracked",) * 3)
    assert min_area_px(p, CAMERA, seen) == pytest.approx(25)
    far = dataclasses.replace(seen, positions_m=10 * at)
    assert min_area_px(p, CAMERA, far) == pytest.approx(25)  # no less than a quarter
    assert min_area_px(p, CAMERA, dataclasses.replace(seen, status=("lost",) * 3)) == 100
    assert min_area_px(p, CAMERA, Estimates.waiting()) == 100
    literal = dataclasses.replace(p, reference_focal_px=0.0, reference_depth_m=0.0)
    assert min_area_px(literal, long, seen) == 100
