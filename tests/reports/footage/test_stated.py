"""What the tracker says of its errors, counted over frames."""

import numpy as np
import pytest

from pjpdaf.interfaces import Estimates
from reports.footage.stated import StatedErrors


def estimates(sd_mm, exchange):
    P = np.array([np.eye(3) * (sd / 1000) ** 2 / 3 for sd in sd_mm])
    return Estimates(np.zeros((3, 3)), P, np.zeros((3, 3)), ("lost",) * 3, exchange)


def test_quantiles_and_shares_of_all_frames_whatever_their_status():
    errors = StatedErrors()
    for frame in range(100):
        sd_mm = (10.2, 49.9 if frame < 60 else 300.5, np.nan)
        errors.add(estimates(sd_mm, np.nan if frame < 20 else 0.2 if frame < 30 else 0.05))
    head, right, left = (errors.error(t) for t in range(3))
    assert (head.median_mm, head.p90_mm, head.sure) == (11, 11, 1.0)
    assert (right.median_mm, right.p90_mm, right.sure) == (50, 301, 0.6)
    assert (left.median_mm, left.sure) == (1000, 0.0)
    doubt = errors.doubt()
    assert doubt.frames == 80
    assert doubt.mean == pytest.approx((10 * 0.2 + 70 * 0.05) / 80)
    assert doubt.doubtful == 10 / 80


def test_without_frames_there_is_nothing():
    assert np.isnan(StatedErrors().error(0).median_mm)
    assert StatedErrors().doubt().frames == 0
