"""Background test by log chroma."""

from __future__ import annotations

import numpy as np
import pytest

from pjpdaf.detector.background import BackgroundSums
from pjpdaf.detector.chroma import ChromaTest, log_chroma
from pjpdaf.detector.small_picture import SmallPicture

WALL_BGR = np.array([107.0, 135.0, 170.0])
FACE_BGR = np.array([79.0, 101.0, 142.0])  # as a shadow of the wall would be, but for its chroma


def picture(rng: np.random.Generator, light: float | np.ndarray = 1.0) -> np.ndarray:
    return np.clip(rng.normal(WALL_BGR * light, 0.9, (60, 80, 3)), 0, 255).round().astype(np.uint8)


@pytest.fixture(scope="module")
def chroma_test() -> ChromaTest:
    rng = np.random.default_rng(1)
    sums = BackgroundSums()
    for _ in range(12):
        sums.add(picture(rng))
    return ChromaTest.of(sums.result(10))


def test_log_chroma_of_a_colour_and_of_the_same_in_another_light():
    colours = np.array([[50.0, 100.0, 200.0], [30.0, 30.0, 30.0]])
    np.testing.assert_allclose(log_chroma(colours), [[np.log(2), np.log(2)], [0, 0]], atol=1e-6)
    moved = log_chroma(colours * np.array([0.5, 1.0, 1.2])) - log_chroma(colours)
    np.testing.assert_allclose(moved, np.tile([np.log(1.2), np.log(2.0)], (2, 1)), atol=1e-6)


def test_a_face_before_a_wall_of_nearly_its_colour_is_seen_and_nothing_else(chroma_test):
    scene = picture(np.random.default_rng(2))
    scene[20:40, 30:50] = np.random.default_rng(4).normal(FACE_BGR, 0.9, (20, 20, 3)).round()
    far = chroma_test(SmallPicture.of(scene)) > 0
    assert far[22:38, 32:48].mean() > 0.99
    far[18:42, 28:52] = False
    assert far.mean() < 0.002


def test_a_shadow_and_the_cameras_white_balance_are_background(chroma_test):
    shadow = picture(np.random.default_rng(2))
    shadow[20:40, 30:50] = np.rint(0.6 * shadow[20:40, 30:50])
    assert chroma_test(SmallPicture.of(shadow)).mean() < 0.01
    balanced = picture(np.random.default_rng(2), light=np.array([1.15, 1.0, 0.9]))
    assert chroma_test(SmallPicture.of(balanced)).mean() < 0.002


def test_black_has_no_chroma(chroma_test):
    assert not chroma_test(SmallPicture.of(np.zeros((60, 80, 3), np.uint8))).any()
