"""Hands that must be in the head's blob, because they are nowhere else."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pjpdaf.tracker.hypotheses.blobs import Blobs
from pjpdaf.tracker.hypotheses.head import follow_head
from pjpdaf.tracker.hypotheses.missing_hand import hand_missing
from pjpdaf.tracker.hypotheses.parameters import HypothesisParameters
from tests.pjpdaf.tracker.hypotheses.test_head_pieces import HEAD_M, VIEWS, track_and_face, view_of
from tests.pjpdaf.tracker.hypotheses.test_split import disc
from tests.strategies import detections

HAND_PX = 1000.0
HAND_M = HEAD_M + np.array([0.10, 0.10, -0.05])
AWAY_M = HEAD_M + np.array([-0.2, 0.40, -0.2])


def blobs(*areas_px: float, missing: bool = False) -> Blobs:
    places = np.array([[100.0 * i, 50.0] for i in range(len(areas_px))])
    return Blobs.of(replace(detections(places, np.array(areas_px)), missing=missing))


@pytest.mark.parametrize(
    ("areas_px", "hands_m", "expected"),
    [
        ((2400, 1000), (HAND_M, AWAY_M), True),
        ((2400, 1000, 900), (HAND_M, AWAY_M), False),
        ((2400, 1000, 200), (HAND_M, AWAY_M), True),  # a fragment is no hand
        ((2400, 1000), (AWAY_M, AWAY_M), False),  # the other hand is hidden elsewhere
        ((2400,), (HAND_M, HAND_M), True),
    ],
)
def test_hand_is_missing_where_it_was_near_and_too_few_blobs_are_left(areas_px, hands_m, expected):
    assert hand_missing(blobs(*areas_px), HEAD_M, np.array(hands_m), HAND_PX) is expected


def test_nothing_is_missing_in_a_picture_that_is_missing():
    hands = np.array([HAND_M, AWAY_M])
    assert not hand_missing(blobs(missing=True), HEAD_M, hands, HAND_PX)


@pytest.mark.parametrize("joined", [False, True])
def test_area_of_a_head_with_a_hand_is_not_learnt(joined):
    """The hand adds a few per cent, which alone would pass for the head."""
    seen = []
    for view in range(2):
        track, face = track_and_face(view)
        hand = disc(face[:, 0].max() + 3.0, face[:, 1].mean(), 10.0)
        seen.append(view_of([np.vstack([face, hand[hand[:, 0] > face[:, 0].max()]])]))
    after, places = follow_head(
        track, tuple(seen), VIEWS, 1 / 3, HypothesisParameters(), joined=(joined, joined)
    )
    assert all(place is not None and place.free is not joined for place in places)
    assert (after.area_m2 == track.area_m2) is joined
    assert np.linalg.norm(after.mean - HEAD_M) < 0.03
