"""Ends of arms at the head are before the face; where two arms meet the depth is unsure."""

from __future__ import annotations

import numpy as np

from pjpdaf.tracker.hypotheses.arm_at_head import BEFORE_FACE_M, before_face, unsure_depth
from pjpdaf.tracker.hypotheses.candidates import BESIDE, HALF, Candidates
from pjpdaf.tracker.hypotheses.geometry import Views
from pjpdaf.tracker.hypotheses.pairs import Pairs
from tests.strategies import rig

VIEWS = Views.of(rig().cameras)
MIDDLE_M = VIEWS.centres_m.mean(axis=0)
DEPTH_M = 1.2


def at(right: float, down: float, depth: float) -> np.ndarray:
    return np.asarray(MIDDLE_M + np.array([right, down, depth]) @ VIEWS.axes)


def candidates(*outlines: bool, part: int = BESIDE) -> Candidates:
    n = len(outlines)
    pixels = tuple(np.zeros((9, 2)) if outline else None for outline in outlines)
    parts = np.full(n, part)
    none = np.zeros((n, 2))
    alone = np.full(n, -1)
    return Candidates(none, np.zeros(n), np.zeros(n, int), parts, none, pixels, alone, np.zeros(n))


def test_only_ends_of_arms_that_are_too_far_away_move_along_their_rays():
    """Candidate 0 is an arm's end, candidate 1 a hand's own piece."""
    points = np.array([at(0.1, 0, 1.5), at(0.1, 0, 1.0), at(0.1, 0, 1.5)])
    number = np.array([[0, 0], [0, 0], [1, 1]])
    C = np.tile(np.eye(3) * 0.3**2, (3, 1, 1))
    pairs = Pairs(points, C, np.ones(3), np.zeros(3), number * 0, number * 0 + BESIDE, number)
    both = candidates(False, True), candidates(False, True)
    moved = before_face(pairs, both, at(0, 0, DEPTH_M), VIEWS)
    wanted = DEPTH_M - BEFORE_FACE_M
    np.testing.assert_allclose(moved.points_m[0], at(0.1 * wanted / 1.5, 0, wanted), atol=1e-9)
    np.testing.assert_array_equal(moved.points_m[1:], points[1:])
    ray = VIEWS.axes[2]
    assert ray @ moved.covariances_m2[0] @ ray < 0.1**2
    assert ray @ moved.covariances_m2[2] @ ray == C[2, 2, 2]


def test_depth_alone_is_unsure_where_two_arms_meet():
    """Candidate 0 is half of a blob of two hands, candidate 1 one of two arms."""
    points = np.array([at(0, 0, 1.0)] * 2)
    number = np.array([[0, 0], [1, 1]])
    C = np.tile(np.eye(3) * 0.01**2, (2, 1, 1))
    pairs = Pairs(points, C, np.ones(2), np.zeros(2), number * 0, number * 0 + HALF, number)
    both = candidates(False, True, part=HALF), candidates(False, True, part=HALF)
    after = unsure_depth(pairs, both, VIEWS).covariances_m2
    ray, across = VIEWS.axes[2], VIEWS.axes[0]
    np.testing.assert_array_equal(after[0], C[0])
    assert ray @ after[1] @ ray > 0.15**2
    np.testing.assert_allclose(across @ after[1] @ across, 0.01**2)
