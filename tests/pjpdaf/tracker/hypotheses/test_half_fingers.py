"""Fingers of two hands in one blob, on drawn hands."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from pjpdaf.tracker.hypotheses.half_fingers import half_fingers

STEP = 3
PALM, FINGER, REACH = 20, 7, 55  # half-width, thickness, from the palm's middle [px]
HAND_PX, THIN_PX = 2800.0, 9.0
UPPER, LOWER = (150, 110), (155, 148)


def hand(canvas: np.ndarray, palm: tuple[int, int], way: int) -> None:
    """A palm with three fingers to the left (-1) or right (1); way 0: a fist."""
    cv2.circle(canvas, palm, PALM, 1, -1)
    for spread in (-14, 0, 14):
        tip = palm[0] + way * REACH, palm[1] + abs(way) * spread
        cv2.line(canvas, palm, tip, 1, FINGER)


def found(upper: int, lower: int) -> np.ndarray:
    canvas = np.zeros((240, 320), np.uint8)
    hand(canvas, UPPER, upper)
    hand(canvas, LOWER, lower)
    assert cv2.connectedComponents(canvas)[0] == 2, "one blob beside the background"
    y, x = np.nonzero(canvas[::STEP, ::STEP])
    pixels = STEP * np.column_stack([x, y]).astype(np.float64)
    return half_fingers(pixels, STEP, np.array([UPPER, LOWER], np.float64), HAND_PX, THIN_PX)


@pytest.mark.parametrize("upper", [-1, 1])
@pytest.mark.parametrize("lower", [-1, 1])
def test_each_half_points_along_its_own_fingers(upper: int, lower: int):
    fingers = found(upper, lower)
    for way, vector in zip((upper, lower), fingers, strict=True):
        assert way * vector[0] > 0.05
        assert abs(vector[1]) < 0.3 * abs(vector[0])


def test_fists_point_nowhere():
    assert np.abs(found(0, 0)).max() < 0.03


def test_a_sliver_of_a_hand_points_nowhere():
    pixels = np.array([[x, y] for x in range(0, 60, STEP) for y in range(0, 60, STEP)], np.float64)
    away = np.array([[30.0, 30.0], [30.0, 110.0]])  # which has fewer than a dozen pixels
    assert not half_fingers(pixels, STEP, away, HAND_PX, THIN_PX)[1].any()
