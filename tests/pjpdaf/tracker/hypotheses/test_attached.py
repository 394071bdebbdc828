"""Blobs on the person's silhouette and apart from it."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest

from pjpdaf.looks import CLOTHED, SKIN, Silhouette
from pjpdaf.tracker.hypotheses.attached import apart_cost, attached, learnt_share
from pjpdaf.tracker.hypotheses.blobs import Blobs
from pjpdaf.tracker.hypotheses.pairs import Pairs
from tests.pjpdaf.tracker.hypotheses.test_head_pieces import HEAD_M, VIEWS, view_of
from tests.pjpdaf.tracker.hypotheses.test_split import disc

STEP = 4
VIEWS_WIDTH, VIEWS_HEIGHT = 640, 480
HAND, BOX = (-60.0, 150.0), (200.0, 150.0)  # from the head [px]


def view(number: int, head_shows: bool = True, arm: bool = True) -> Blobs:
    """Head, a hand at the end of an arm and a box beside the person."""
    at = VIEWS.project(HEAD_M)[0][number]
    parts = [disc(*(at + off), 25.0) for off in ((0.0, 0.0), HAND, BOX)]
    classes = np.zeros((VIEWS_HEIGHT // STEP, VIEWS_WIDTH // STEP), np.uint8)

    def cell(off: tuple[float, float]) -> tuple[int, int]:
        x, y = ((at + off + 0.5) / STEP - 0.5).round().astype(int)
        return int(x), int(y)

    if arm:
        cv2.line(classes, cell((0.0, 0.0)), cell(HAND), CLOTHED, 5)
    for off in ((0.0, 0.0), HAND, BOX)[0 if head_shows else 1 :]:
        cv2.circle(classes, cell(off), 25 // STEP, SKIN, -1)
    if not head_shows:
        cv2.circle(classes, cell((0.0, 0.0)), 60 // STEP, 0, -1)
    seen = view_of(parts)
    return replace(seen, looks=replace(seen.looks, silhouette=Silhouette(classes, STEP)))


def both(**how: bool) -> tuple[Blobs, ...]:
    return tuple(view(v, **how) for v in range(2))


def pairs(*blobs: tuple[int, int]) -> Pairs:
    n = len(blobs)
    none = np.zeros(n)
    index = np.array(blobs, np.intp)
    return Pairs(np.zeros((n, 3)), np.tile(np.eye(3), (n, 1, 1)), none, none, index, index, index)


def test_a_hand_hangs_on_the_head_by_its_arm_and_a_box_does_not():
    for hangs in attached(both(), HEAD_M, VIEWS):
        assert hangs.tolist() == [True, True, False]


def test_where_no_head_shows_nothing_is_apart():
    for hangs in attached(both(head_shows=False), HEAD_M, VIEWS):
        assert hangs.all()


def test_where_there_is_no_silhouette_nothing_is_apart():
    blind = tuple(replace(v, looks=replace(v.looks, silhouette=None)) for v in both())
    assert all(hangs.all() for hangs in attached(blind, HEAD_M, VIEWS))


def test_what_is_apart_in_every_view_that_shows_it_costs():
    hangs = attached(both(), HEAD_M, VIEWS)
    of = pairs((1, 1), (2, 2), (1, 2), (2, -1))
    np.testing.assert_allclose(apart_cost(of, hangs, 1.0, 6.0), [0, 6, 0, 6])
    np.testing.assert_allclose(apart_cost(of, hangs, 0.75, 6.0), [0, 3, 0, 3])


def test_of_a_person_whose_arms_are_never_seen_nothing_is_asked():
    hangs = attached(both(arm=False), HEAD_M, VIEWS)
    of, share = pairs((1, 1), (2, 2)), 1.0
    for _ in range(8):
        share = learnt_share(share, of, (0, 1), hangs, 1 / 3)
    assert share < 0.5
    often = 1.0
    for _ in range(80):
        often = learnt_share(often, of, (0, 1), hangs, 1 / 30)
    assert often == pytest.approx(share)
    np.testing.assert_array_equal(apart_cost(of, hangs, share, 6.0), 0.0)
    assert learnt_share(share, of, (2, 3), hangs, 1 / 3) == share  # at the face, unseen
