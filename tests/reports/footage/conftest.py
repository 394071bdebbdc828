"""Footage without pictures: frames and estimates of a given status."""

import numpy as np
import pytest

from pjpdaf.frames import StereoFrame
from pjpdaf.interfaces import Estimates
from reports.footage.track_record import TrackRecord

PERIOD_S = 0.5
PICTURE = np.zeros((4, 6, 3), np.uint8)


def estimates_of(status):
    """Estimates with standard deviations 10, 20, 30 mm; NaN while waiting."""
    positions = np.array([[0.0, -0.3, 1.2], [-0.2, 0.1, 1.1], [0.2, 0.1, 1.1]])
    positions[[s == "waiting" for s in status]] = np.nan
    covariances = np.tile(np.diag([0.01, 0.02, 0.03]) ** 2, (3, 1, 1))
    return Estimates(positions, covariances, np.zeros((3, 3)), tuple(status))


@pytest.fixture
def record_of():
    """Make the record of a footage from the status of each frame's targets.

    jpeg: the picture of a frame by its index; without it no picture, but the number.
    """

    def make(statuses, missing=(), jpeg=lambda index: b"jpeg %d" % index):
        record = TrackRecord(PERIOD_S)
        for index, status in enumerate(statuses):
            pictures = (None if index in missing else PICTURE, PICTURE)
            frame = StereoFrame(index, index * PERIOD_S, pictures)
            record.add(frame, ((), ()), estimates_of(status), lambda i=index: jpeg(i))
        return record

    return make
