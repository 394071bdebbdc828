"""Opening of masks by large discs."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from pjpdaf.detector.discs import opened_by


@pytest.mark.parametrize("size", [1, 3, 5, 9, 15, 21, 31, 39])
def test_an_opening_has_the_bits_of_opencv(size):
    rng = np.random.default_rng(size)
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (size, size))
    kept = 0
    for _ in range(20):
        height, width = rng.integers(3, 120, 2)
        mask = np.zeros((height, width), np.uint8)
        noise = cv2.GaussianBlur(rng.normal(size=(height - 2, width - 2)), (0, 0), size / 4 + 1)
        mask[1:-1, 1:-1] = noise > np.quantile(noise, rng.uniform(0.0, 0.6))
        opened = opened_by(disc, mask)
        np.testing.assert_array_equal(opened, cv2.morphologyEx(mask, cv2.MORPH_OPEN, disc))
        kept += int(opened.sum())
    assert kept > 0
