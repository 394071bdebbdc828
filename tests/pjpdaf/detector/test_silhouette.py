"""Reduced pictures."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from pjpdaf.detector.silhouette import reduced


@pytest.mark.parametrize("size", [(640, 480), (636, 477), (600, 338)])
def test_a_reduced_picture_has_the_bits_of_an_average(size):
    width, height = size
    # Neighbours alike, so that many sums are halfway between two levels.
    picture = np.random.default_rng(1).integers(100, 103, (height, width, 3)).astype(np.uint8)
    picture[: height // 2] = 255 - picture[: height // 2]
    average = cv2.resize(picture, (width // 4, height // 4), interpolation=cv2.INTER_AREA)
    np.testing.assert_array_equal(reduced(picture), average)
