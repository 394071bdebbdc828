"""The record of footage: shares and gaps of a worked example, a size that is bounded."""

import numpy as np
import pytest

from reports.footage.track_record import MAX_NAMED, MAX_SAMPLES

WAITING, TRACKED = ("waiting",) * 3, ("tracked",) * 3
LEFT_LOST = ("tracked", "tracked", "lost")


def test_shares_gaps_and_deviations_of_a_worked_example(record_of):
    statuses = [WAITING] * 2 + [TRACKED] * 5 + [LEFT_LOST] * 3
    record = record_of(statuses, missing=(4,))
    head, _, left = record.summaries()
    assert (record.frames, record.seconds, record.first_frame, record.first_s) == (10, 5.0, 2, 1.0)
    assert left.frames == {"waiting": 2, "tracked": 5, "coasting": 0, "lost": 3}
    assert left.shares["tracked"] == pytest.approx(5 / 8)  # of the frames since tracking began
    assert left.shares["waiting"] == pytest.approx(2 / 10)  # of all frames
    assert (left.longest_gap_s, head.longest_gap_s) == (1.5, 0.0)
    assert left.sd_mm == pytest.approx((10.0, 20.0, 30.0))
    assert (record.missing_pictures, record.missing_frames) == (1, [4])
    assert record.verdict() == (
        "Found since tracking began in frame 2 (1.0 s): "
        "head 100 %, right hand 100 %, left hand 62 %. "
        "The tracker does not say how sure it is of right and left."
    ).replace(" %", "\N{NO-BREAK SPACE}%")


def test_tracking_that_never_begins(record_of):
    record = record_of([WAITING] * 4)
    assert record.first_frame is None
    assert record.verdict().startswith("Tracking never began")
    assert "--skin-sample" in record.verdict()
    record.enough_detected = 3
    assert "left and right view may be exchanged" in record.verdict()
    assert all(np.isnan(summary.sd_mm).all() for summary in record.summaries())


def test_long_footage_is_thinned_evenly(record_of):
    record = record_of([TRACKED] * (2 * MAX_SAMPLES + 1), missing=range(100))
    frames = [sample.frame for sample in record.samples]
    assert MAX_SAMPLES / 2 <= len(frames) <= MAX_SAMPLES
    assert len(set(np.diff(frames))) == 1
    assert len(record.missing_frames) == MAX_NAMED
    assert record.missing_pictures == 100
