"""Disparity of parts of a blob: two discs at two depths, merged in both views."""

from __future__ import annotations

import numpy as np

from pjpdaf.tracker.hypotheses.contour import disparity, row_ends, row_shift
from pjpdaf.tracker.hypotheses.geometry import Views
from tests.pjpdaf.tracker.hypotheses.test_split import disc
from tests.strategies import rig

NEAR_PX, FAR_PX = 60.0, 42.0  # disparities


def parts_of(near_x: float, far_x: float) -> tuple[np.ndarray, np.ndarray]:
    """The blob of two discs and its half left of the middle, on a lattice of 1 px."""
    blob = np.unique(
        np.rint(np.concatenate([disc(near_x, 100, 20, 1.0), disc(far_x, 100, 20, 1.0)])), axis=0
    )
    return blob[blob[:, 0] < 0.5 * (near_x + far_x)], blob


def test_own_outline_has_the_disparity_of_the_part_and_the_centroid_has_not():
    left_half, left = parts_of(200.0, 230.0)
    right_half, right = parts_of(200.0 - NEAR_PX, 230.0 - FAR_PX)
    found = disparity(row_ends(left_half, left, 1.0), row_ends(right_half, right, 1.0))
    assert found is not None
    assert abs(found - NEAR_PX) < 1.0
    centroids = left_half[:, 0].mean() - right_half[:, 0].mean()
    assert abs(centroids - NEAR_PX) > 1.2


def test_split_line_is_no_end():
    half, blob = parts_of(200.0, 230.0)
    ends = row_ends(half, blob, 1.0).ends
    assert np.isfinite(ends[:, 0]).all()
    assert not np.isfinite(ends[len(ends) // 2, 1])


def test_parts_without_common_rows_have_no_disparity():
    half, blob = parts_of(200.0, 230.0)
    below = np.array([0.0, 100.0])
    assert disparity(row_ends(half, blob, 1.0), row_ends(half + below, blob + below, 1.0)) is None


def test_row_shift_is_that_of_the_epipolar_line():
    views = Views.of(rig().cameras)
    point = views.centres_m[0] + 1.2 * views.rays(0, np.array([[300.0, 220.0]]))[0]
    pixels, _ = views.project(point)
    assert abs(row_shift(views, pixels[0]) - (pixels[1, 1] - pixels[0, 1])) < 0.5
