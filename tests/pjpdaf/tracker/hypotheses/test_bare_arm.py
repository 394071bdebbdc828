"""The ends of straight and bent arms, drawn on a lattice."""

from __future__ import annotations

import numpy as np

from pjpdaf.tracker.hypotheses.bare_arm import courses, end_at, ends_and_middles

STEP = 4.0


def bar(x0: float, y0: float, x1: float, y1: float) -> np.ndarray:
    x, y = np.meshgrid(np.arange(x0, x1 + 1, STEP), np.arange(y0, y1 + 1, STEP))
    return np.column_stack([x.ravel(), y.ravel()])


STRAIGHT = bar(0, 0, 200, 40)
# Upper arm down, forearm up beside it: hand and sleeve at the top, the elbow at the bottom.
BENT = np.unique(
    np.vstack([bar(0, 0, 40, 200), bar(0, 160, 120, 200), bar(80, 0, 120, 200)]), axis=0
)


def centres(parts: tuple[np.ndarray, ...]) -> np.ndarray:
    """Centres (2, 2) of two parts, the left one first."""
    found = np.array([part.mean(axis=0) for part in parts])
    return found[np.argsort(found[:, 0])]


def test_ends_of_a_straight_bar_lie_half_a_length_from_its_tips():
    ends, _ = ends_and_middles(STRAIGHT, STEP, length_px=80.0)
    np.testing.assert_allclose(centres(ends), [[40, 20], [160, 20]], atol=5.0)


def test_ends_of_a_bent_arm_are_hand_and_sleeve_not_the_elbow():
    ends, _ = ends_and_middles(BENT, STEP, length_px=60.0)
    np.testing.assert_allclose(centres(ends), [[20, 30], [100, 30]], atol=8.0)


def test_hands_that_meet_are_each_on_its_own_arms_side_of_the_middle():
    """Two forearms from elbows at the far ends of the bar."""
    ends, middles = ends_and_middles(STRAIGHT, STEP, length_px=60.0)
    np.testing.assert_allclose(centres(middles), [[70, 20], [130, 20]], atol=8.0)
    for end, middle in zip(ends, middles, strict=True):
        assert (end[:, 0].mean() < 100) == (middle[:, 0].mean() < 100)


def test_a_way_follows_the_arm_and_does_not_jump_to_another_piece():
    way, _ = courses(np.vstack([BENT, [[400.0, 0.0]]]), STEP, start=np.array([0.0, 0.0]))
    at = int(np.flatnonzero((BENT == [120, 0]).all(axis=1))[0])
    assert way[at] > 350.0  # 120 px as the crow flies
    assert np.isinf(way[-1])


def test_hand_of_an_arm_that_reaches_to_a_face_is_the_arms_end():
    centre = end_at(STRAIGHT, STEP, np.array([260.0, 20.0]), length_px=80.0)
    np.testing.assert_allclose(centre, [172, 20], atol=5.0)
