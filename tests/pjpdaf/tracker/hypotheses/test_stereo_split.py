"""One cut of a merged blob in both views: discs at two depths, and what each cut says of them."""

from __future__ import annotations

import numpy as np
import pytest

from pjpdaf.interfaces import Detections
from pjpdaf.tracker.hypotheses.blobs import Blobs
from pjpdaf.tracker.hypotheses.candidates import HALF, OTHER_HALF, Candidates, candidates
from pjpdaf.tracker.hypotheses.contour import row_shift
from pjpdaf.tracker.hypotheses.pairs import Pairs, pair_candidates
from pjpdaf.tracker.hypotheses.parameters import (
    CandidateParameters,
    CostParameters,
    NoiseParameters,
)
from pjpdaf.tracker.hypotheses.split import halves
from pjpdaf.tracker.hypotheses.stereo_split import halve_together, split_together
from tests.pjpdaf.tracker.hypotheses.test_candidates import FRONT_M, HAND_M, STEP, VIEWS, merged

P = CandidateParameters(draw_together=0.0)
SECOND_M = -0.16, 0.05, 0.06  # nearer to the cameras than the first hand, beside and above it
FAR_PX, NEAR_PX = 41.0, 50.0  # disparities
LATTICE_PX = 4.0
DOWN_PX = np.array([0.0, 5 * STEP])
# Two hands in the left view: place (x, y) [px] and direction [deg] of the farther, of the nearer.
POSTURES = [
    ((342, 306), 20, (370, 277), 20),
    ((343, 330), 0, (343, 280), 10),
    ((352, 288), 30, (361, 326), -20),
    ((344, 309), 45, (368, 269), 45),
    ((340, 300), 90, (372, 290), 70),
    ((345, 300), -30, (365, 335), 0),
]


def hand(x: float, y: float, deg: float) -> np.ndarray:
    """Pixels of an ellipse of 68 x 40 px."""
    px, py = (axis.ravel() for axis in np.meshgrid(np.arange(-40, 41.0), np.arange(-40, 41.0)))
    c, s = np.cos(np.deg2rad(deg)), np.sin(np.deg2rad(deg))
    inside = ((px * c + py * s) / 34.0) ** 2 + ((py * c - px * s) / 20.0) ** 2 <= 1.0
    return np.column_stack([px, py])[inside] + (x, y)


def blobs(posture: tuple) -> tuple[np.ndarray, np.ndarray]:
    """The blob of both hands in the left and in the right view, on a lattice."""
    far, far_deg, near, near_deg = posture
    views = []
    for d_far, d_near in ((0.0, 0.0), (FAR_PX, NEAR_PX)):
        both = [hand(far[0] - d_far, far[1], far_deg), hand(near[0] - d_near, near[1], near_deg)]
        whole = np.unique(np.concatenate(both), axis=0)
        whole = whole[np.lexsort((whole[:, 0], whole[:, 1]))]
        views.append(whole[(whole % LATTICE_PX == 0).all(axis=1)])
    return views[0], views[1]


def errors(left_px: np.ndarray, right_px: np.ndarray, posture: tuple) -> tuple[float, float]:
    """Largest errors [px] of the centres in the left view, and of the disparities."""
    centres = np.array([posture[0], posture[2]], float)
    a = left_px[np.linalg.norm(left_px[:, None] - centres, axis=2).argmin(axis=0)]
    there = centres - np.array([[FAR_PX, 0.0], [NEAR_PX, 0.0]])
    b = right_px[np.linalg.norm(right_px[:, None] - there, axis=2).argmin(axis=0)]
    off = (a - b)[:, 0] - (FAR_PX, NEAR_PX)
    return float(np.linalg.norm(a - centres, axis=1).max()), float(np.abs(off).max())


@pytest.mark.parametrize("posture", POSTURES)
def test_one_cut_gives_each_hand_its_own_disparity(posture):
    split = split_together(*blobs(posture), LATTICE_PX, 0.0, 1.0)
    assert split is not None
    place, disparity = errors(split.left_px, split.right_px, posture)
    assert place < 2.5
    assert disparity < 1.2


def test_cuts_made_in_each_view_alone_do_not():
    worst = 0.0
    for posture in POSTURES:
        left, right = (halves(pixels, 1.0) for pixels in blobs(posture))
        assert left is not None
        assert right is not None
        worst = max(worst, errors(left[0], right[0], posture)[1])
    assert worst > 4.0


def halves_of(hands_m: np.ndarray) -> tuple[Pairs, tuple[Candidates, Candidates]]:
    """The sightings of both hands' halves, and the candidates."""
    seen = merged(hands_m)
    metre_px = VIEWS.focal_px / VIEWS.project(hands_m.mean(axis=0))[1]
    area_m2 = np.pi * HAND_M**2
    one, two = (
        candidates(view, None, float(metre_px[v]), area_m2, False, P) for v, view in enumerate(seen)
    )
    hand_px = float(area_m2 * metre_px[0] ** 2), float(area_m2 * metre_px[1] ** 2)
    one, two = halve_together(VIEWS, seen, (one, two), hand_px, P)
    pairs = pair_candidates(VIEWS, (one, two), hands_m, NoiseParameters(), CostParameters(), seen)
    half = ((pairs.part == HALF) | (pairs.part == OTHER_HALF)).all(axis=1)
    return pairs[half], (one, two)


@pytest.mark.parametrize("views", [2, 1])
def test_halves_that_are_left_for_later_are_the_same(views):
    """Of a blob that both views show, and of one that is no blob in the other view."""
    seen = merged(np.array([FRONT_M, FRONT_M + np.array(SECOND_M)]))
    if views == 1:
        seen = seen[0], Blobs.of(Detections.none())
    metre_px, area_m2 = VIEWS.focal_px / 1.0, np.pi * HAND_M**2
    hand_px = float(area_m2 * metre_px[0] ** 2), float(area_m2 * metre_px[1] ** 2)
    found = []
    for cut in (True, False):
        one, two = (
            candidates(view, None, float(metre_px[v]), area_m2, False, P, cut=cut)
            for v, view in enumerate(seen)
        )
        assert bool(one.uncut) != cut
        found.append(halve_together(VIEWS, seen, (one, two), hand_px, P))
    assert (found[0][0].mate >= 0).any() == (views == 2)
    for now, later in zip(*found, strict=True):
        assert not later.uncut
        np.testing.assert_array_equal(now.part, later.part)
        np.testing.assert_array_equal(now.centres_px, later.centres_px)
        np.testing.assert_array_equal(now.areas_px, later.areas_px)
        np.testing.assert_array_equal(now.mate, later.mate)


def test_halves_pair_with_their_mates_alone():
    hands = np.array([FRONT_M, FRONT_M + np.array(SECOND_M)])
    pairs, (one, two) = halves_of(hands)
    np.testing.assert_array_equal(pairs.part[:, 0], pairs.part[:, 1])
    for k in np.flatnonzero(one.mate >= 0):
        assert two.mate[one.mate[k]] == k
        assert one.blob[k] == two.blob[one.mate[k]]
    assert (one.mate >= 0).sum() == len(pairs) == 2


def test_a_hidden_hand_makes_the_depth_uncertain():
    """Where both parts have one disparity although much is hidden, all outlines may be of one."""
    apart = np.array([FRONT_M, FRONT_M + np.array(SECOND_M)])
    behind = np.array([FRONT_M, FRONT_M + np.array([-0.11, 0.025, 0.0])])
    known, hidden = (halves_of(hands)[1][0].between_px for hands in (apart, behind))
    assert hidden.max() > 2.0 * known.max()


def test_too_few_rows_are_not_split():
    line = np.column_stack([np.arange(0.0, 60.0, STEP), np.zeros(20)])
    assert split_together(line, line - (40.0, 0.0), STEP, 0.0, 1.0) is None


def test_rows_of_the_right_view_may_be_lower():
    hands = np.array([FRONT_M, FRONT_M + np.array(SECOND_M)])
    left, right = (view.looks.pixels[0] for view in merged(hands))
    down = row_shift(VIEWS, left.mean(axis=0))
    level = split_together(left, right, STEP, down, VIEWS.scale)
    lower = split_together(left, right + DOWN_PX, STEP, down + DOWN_PX[1], VIEWS.scale)
    assert level is not None
    assert lower is not None
    np.testing.assert_allclose(lower.left_px, level.left_px, atol=1e-9)
    np.testing.assert_allclose(lower.right_px, level.right_px + DOWN_PX, atol=1e-9)
