"""A head in pieces is one blob; a hand beside it is not part of it."""

from __future__ import annotations

import numpy as np

from pjpdaf.interfaces import Detections
from pjpdaf.looks import BlobLooks
from pjpdaf.tracker.hypotheses.blobs import Blobs
from pjpdaf.tracker.hypotheses.geometry import Views
from pjpdaf.tracker.hypotheses.head import HeadTrack
from pjpdaf.tracker.hypotheses.head_pieces import join_head
from tests.pjpdaf.tracker.hypotheses.test_split import disc
from tests.strategies import rig

VIEWS = Views.of(rig().cameras)
HEAD_M = np.array([0.0, -0.1, 1.2])
RADIUS_M = 0.09


def view_of(parts: list[np.ndarray]) -> Blobs:
    centres = np.array([part.mean(axis=0) for part in parts])
    n = len(parts)
    none = np.zeros((n, 2))
    return Blobs.of(
        Detections(
            centres,
            np.tile(np.eye(2), (n, 1, 1)),
            np.column_stack([centres, np.full((n, 2), 10.0), np.zeros(n)]),
            np.array([9.0 * len(part) for part in parts]),
            evidence=np.arange(3.0 * n).reshape(n, 3),
            looks=BlobLooks(tuple(parts), 9.0, none, none),
        )
    )


def track_and_face(view: int = 0) -> tuple[HeadTrack, np.ndarray]:
    pixels, depth = VIEWS.project(HEAD_M)
    radius_px = RADIUS_M * VIEWS.focal_px[view] / depth[view]
    face = disc(*pixels[view], radius_px)
    shape = np.eye(2) * RADIUS_M**2 / 4
    return HeadTrack(HEAD_M, np.eye(3), np.pi * RADIUS_M**2, shape), face


def test_fringe_and_face_are_one_blob_and_the_hand_stays():
    track, face = track_and_face()
    middle = face[:, 1].mean()
    fringe, rest = face[face[:, 1] < middle - 12], face[face[:, 1] > middle - 6]
    hand = disc(face[:, 0].mean() + 200.0, middle + 100.0, 20.0)
    left = view_of([fringe, hand, rest])
    joined, untouched = join_head(track, (left, view_of([hand])), VIEWS)
    assert len(joined) == 2
    np.testing.assert_allclose(joined.centres_px[0], hand.mean(axis=0))
    np.testing.assert_allclose(joined.areas_px[1], left.areas_px[[0, 2]].sum())
    assert np.linalg.norm(joined.centres_px[1] - face.mean(axis=0)) < 4.0
    assert joined.evidence is not None
    np.testing.assert_allclose(joined.evidence[1], left.evidence[2])  # of the larger piece
    assert len(untouched) == 1


def test_hand_beside_a_whole_face_is_not_joined():
    track, face = track_and_face()
    edge = face[:, 0].max()
    hand = disc(edge + 15.0, face[:, 1].mean(), 12.0)
    (joined, _) = join_head(track, (view_of([face, hand]), view_of([hand])), VIEWS)
    assert len(joined) == 2
