"""Noise of background frames, and the blur against it."""

from __future__ import annotations

import numpy as np
import pytest

from pjpdaf.detector.exposure import AIM, BLUR_MAX_PX, Exposure, exposure_of


def pictures(level: float, noise: float, count: int = 6, flicker: float = 0.0) -> list[np.ndarray]:
    rng = np.random.default_rng(3)
    scene = level * np.linspace(0.9, 1.1, 160)[None, :, None] * np.ones((120, 1, 3))
    drawn = []
    for i in range(count):
        noisy = scene * (1 + flicker * (-1) ** i) + rng.normal(0, noise, scene.shape)
        drawn.append(np.clip(np.rint(noisy), 0, 255).astype(np.uint8))
    return drawn


def test_quiet_pictures_stay_as_they_are():
    quiet = pictures(120, 3)
    exposure = exposure_of(quiet)
    assert exposure == Exposure()
    assert exposure(quiet[0]) is quiet[0]


def test_flicker_is_no_noise():
    assert exposure_of(pictures(120, 3, flicker=0.05)) == Exposure()


def test_one_picture_shows_no_noise():
    assert exposure_of(pictures(120, 30, count=1)) == Exposure()


@pytest.mark.parametrize(("level", "noise"), [(110, 11), (40, 4), (60, 8)])
def test_the_blur_brings_the_noise_down_to_its_aim(level, noise):
    noisy = pictures(level, noise)
    exposure = exposure_of(noisy)
    before = np.std(noisy[1].astype(float) - noisy[0], ddof=1) / 2**0.5
    one, two = (exposure(p)[8:-8, 8:-8].astype(float) for p in noisy[:2])
    after = np.std(two - one, ddof=1) / 2**0.5
    assert before == pytest.approx(noise, rel=0.1)
    assert after / level == pytest.approx(AIM, rel=0.3)


def test_the_blur_is_bounded():
    assert exposure_of(pictures(20, 40)).blur_px <= BLUR_MAX_PX
