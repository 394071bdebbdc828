"""Ghosts of a cup and its shadow that the background was learnt with."""

from __future__ import annotations

import numpy as np
import pytest

from pjpdaf.detector.background import BackgroundSums
from pjpdaf.detector.ghost import GhostTest
from pjpdaf.detector.small_picture import SmallPicture

TABLE, CUP, HAND = (80.0, 115.0, 165.0), (40.0, 110.0, 30.0), (79.0, 90.0, 142.0)
AT = np.s_[50:62, 60:70]
SHADOW = np.s_[58:64, 50:60]


def table(seed: int, cup: bool = False, light: float = 1.0) -> np.ndarray:
    scene = np.random.default_rng(seed).normal(TABLE, 2.0, (120, 160, 3))
    if cup:
        scene[SHADOW] *= 0.6
        scene[AT] = CUP
    return np.clip(scene * light, 0, 255).round().astype(np.uint8)


@pytest.fixture(scope="module")
def ghosts() -> GhostTest:
    sums = BackgroundSums()
    for seed in range(10):
        sums.add(table(seed, cup=True))
    return GhostTest.of(sums.result(10))


def test_nothing_is_a_ghost_while_the_cup_stands(ghosts):
    assert ghosts(SmallPicture.of(table(20, cup=True))) is None


@pytest.mark.parametrize("light", [1.0, 0.8])
def test_table_where_cup_and_shadow_were_is_a_ghost_and_nothing_else(ghosts, light):
    mask = ghosts(SmallPicture.of(table(20, light=light)))
    assert mask is not None
    assert mask[AT].all()
    assert mask[SHADOW].all()
    mask[48:66, 48:72] = 0
    assert not mask.any()


def test_a_hand_where_the_cup_was_is_none(ghosts):
    """It is as bright as the table."""
    scene = table(20)
    scene[46:70, 40:76] = np.rint(np.array(HAND) * 0.8)
    mask = ghosts(SmallPicture.of(scene))
    assert mask is None or mask[AT].mean() < 0.1


def test_where_what_is_around_is_no_one_surface_nothing_is_known():
    """A shelf of books behind a face of the colour of some of them."""
    rng = np.random.default_rng(3)
    books = rng.uniform(30, 220, (1, 40, 3)).repeat(4, axis=1).repeat(120, axis=0)
    sums = BackgroundSums()
    for seed in range(10):
        sums.add(
            np.clip(books + np.random.default_rng(seed).normal(0, 2, books.shape), 0, 255)
            .round()
            .astype(np.uint8)
        )
    test = GhostTest.of(sums.result(10))
    face = books.round().astype(np.uint8)
    face[40:80, 60:90] = np.median(books.reshape(-1, 3), axis=0).round()
    mask = test(SmallPicture.of(face))
    assert mask is None or mask[40:80, 60:90].mean() < 0.2
