"""Background: circular hue, floors, false foreground, shadows."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pjpdaf.detector.adaptation import BlobDetectorParameters
from pjpdaf.detector.background import (
    UNIFORM_SD_DEG,
    Background,
    BackgroundParameters,
    BackgroundSums,
    BackgroundTest,
    is_foreground,
    prepare,
)
from pjpdaf.detector.skin import HUE_STEP_DEG, to_hsv
from pjpdaf.errors import BenchError


def colour(hue_deg: float, saturation: float, value: float) -> np.ndarray:
    hsv = np.array([[[hue_deg % 360, saturation, value]]], np.float32)
    return cv2.cvtColor(hsv, cv2.COLOR_HSV2BGR)[0, 0] * 255


def noisy(picture: np.ndarray, rng: np.random.Generator, sd: float = 3.0) -> np.ndarray:
    return np.clip(picture + rng.normal(0, sd, picture.shape), 0, 255).round().astype(np.uint8)


def scene() -> np.ndarray:
    """Grey wall, brown wood, red cloth (hue about 0), dark corner: float BGR (120, 160, 3)."""
    picture = np.full((120, 160, 3), 150.0)
    picture[60:, :80] = colour(25, 0.5, 0.45)
    picture[60:, 80:] = colour(0, 0.7, 0.6)
    picture[:30, :40] = 25.0
    return picture


def learn(pictures, frames_min: int = 2) -> Background:
    sums = BackgroundSums()
    for picture in pictures:
        sums.add(picture)
    return sums.result(frames_min)


def prepared(background: Background, **changes: float) -> BackgroundTest:
    return prepare(background, BackgroundParameters(**changes))


def foreground(test: BackgroundTest, picture: np.ndarray) -> np.ndarray:
    """Foreground of a whole picture, bool (h, w)."""
    at = np.arange(picture.shape[0] * picture.shape[1])
    return is_foreground(test, to_hsv(picture), at).reshape(picture.shape[:2])


def test_mean_and_deviation_are_those_of_the_pixels():
    rng = np.random.default_rng(0)
    pictures = [noisy(scene(), rng) for _ in range(12)]
    background = learn(pictures)
    hsv = np.array([to_hsv(p) for p in pictures]).astype(float)
    np.testing.assert_allclose(background.mean[..., 1:], hsv[..., 1:].mean(0) / 255, atol=1e-6)
    sd = hsv[..., 1:].std(0, ddof=1) / 255
    np.testing.assert_allclose(background.sd[..., 1:], sd, atol=1e-6)
    # Far from 0 and narrow, circular statistics are the plain ones.
    wood = (slice(60, None), slice(0, 80), 0)
    hue = hsv[..., 0][:, 60:, :80] * HUE_STEP_DEG
    np.testing.assert_allclose(background.mean[wood], hue.mean(0), atol=0.1)
    np.testing.assert_allclose(background.sd[wood], hue.std(0, ddof=1), rtol=0.02)


def test_hue_that_crosses_zero_is_narrow_and_grey_hue_is_uniform():
    rng = np.random.default_rng(1)
    background = learn(noisy(scene(), rng) for _ in range(20))
    red = background.mean[60:, 80:, 0]
    assert np.abs((red + 180) % 360 - 180).max() < 4
    assert background.sd[60:, 80:, 0].max() < 6
    grey = background.sd[40:60, :, 0]
    assert (grey > 30).mean() > 0.5
    assert grey.max() <= np.float32(UNIFORM_SD_DEG)


@given(turn=st.integers(0, 255), hues=st.lists(st.integers(0, 20), min_size=2, max_size=12))
def test_hue_statistics_turn_with_the_hue(turn, hues):
    """Rotating every hue rotates the mean and leaves the deviation."""

    def learnt(shift: int) -> tuple[float, float]:
        # Colours whose hue survives the conversion to BGR and back: saturated and bright.
        hsv = np.array([[[[(h + shift) % 256, 255, 255]]] for h in hues], np.uint8)
        pictures = [cv2.cvtColor(x, cv2.COLOR_HSV2BGR_FULL) for x in hsv]
        background = learn(pictures)
        return float(background.mean[0, 0, 0]), float(background.sd[0, 0, 0])

    mean, sd = learnt(0)
    turned_mean, turned_sd = learnt(turn)
    moved = (turned_mean - mean - turn * HUE_STEP_DEG + 180) % 360 - 180
    assert abs(moved) < 1.5 * HUE_STEP_DEG  # the conversion rounds hue to a step
    assert turned_sd == pytest.approx(sd, abs=HUE_STEP_DEG)


@pytest.mark.parametrize(("frames", "most"), [(10, 0.005), (20, 0.003)])
def test_false_foreground(frames, most):
    rng = np.random.default_rng(2)
    test = prepared(learn(noisy(scene(), rng) for _ in range(frames)))
    rate = np.mean([foreground(test, noisy(scene(), rng)).mean() for _ in range(5)])
    # Chi-square alone would give 0.001 at this threshold; the dark corner has heavier tails.
    assert rate < most


def test_without_floors_and_with_few_frames_it_is_much_worse():
    rng = np.random.default_rng(3)
    background = learn(noisy(scene(), rng) for _ in range(3))
    floors = {"hue_sd_floor_deg": 1e-3, "sat_sd_floor": 1e-4, "val_sd_floor": 1e-4}
    raw = prepared(background, shadow_min=1.0, **floors)
    rate = foreground(raw, noisy(scene(), rng)).mean()
    assert rate > 0.02


def test_skin_on_every_background_is_foreground():
    rng = np.random.default_rng(4)
    test = prepared(learn(noisy(scene(), rng) for _ in range(12)))
    hands = scene()
    hands[20:100, 60:100] = colour(18, 0.45, 0.8)
    far = foreground(test, noisy(hands, rng))
    assert far[20:100, 60:100].mean() > 0.999


@pytest.mark.parametrize("light", [0.9, 0.75, 0.6, 0.55])
def test_a_shadow_on_wood_is_not_foreground(light):
    rng = np.random.default_rng(5)
    background = learn(noisy(scene(), rng) for _ in range(12))
    shaded = scene()
    shaded[70:110, 10:70] *= light
    picture = noisy(shaded, rng)
    inside = (slice(70, 110), slice(10, 70))
    with_rule = foreground(prepared(background), picture)[inside].mean()
    without = foreground(prepared(background, shadow_min=1.0), picture)[inside].mean()
    # 0.55: noise of 3 grey levels takes some pixels below shadow_min = 0.5.
    assert with_rule < (0.01 if light > 0.55 else 0.06)
    assert without > with_rule
    if light <= 0.6:
        assert without > 0.9


def test_a_subset_of_pixels_gets_the_same_answer():
    rng = np.random.default_rng(6)
    test = prepared(learn(noisy(scene(), rng) for _ in range(12)))
    picture = noisy(scene()[::-1], rng)
    whole = foreground(test, picture).ravel()
    at = np.flatnonzero(rng.random(whole.size) < 0.1)
    np.testing.assert_array_equal(is_foreground(test, to_hsv(picture), at), whole[at])


def test_too_few_frames_is_one_line():
    with pytest.raises(BenchError, match="at least 10 person-free frames, got 3") as fault:
        learn([scene().astype(np.uint8)] * 3, frames_min=10)
    assert "\n" not in str(fault.value)


def test_pictures_of_two_sizes_are_refused():
    with pytest.raises(BenchError, match="one size, got 160x120 and 8x4"):
        learn([scene().astype(np.uint8), np.zeros((4, 8, 3), np.uint8)])


def test_a_deep_shadow_is_not_foreground_where_shadows_may_be_deep():
    rng = np.random.default_rng(6)
    background = learn(noisy(scene(), rng) for _ in range(12))
    shaded = scene()
    shaded[70:110, 10:70] *= 0.4
    picture = noisy(shaded, rng)
    inside = (slice(70, 110), slice(10, 70))
    deep = prepared(background, shadow_min=BlobDetectorParameters().background.shadow_min)
    assert foreground(deep, picture)[inside].mean() < 0.02
    assert foreground(prepared(background), picture)[inside].mean() > 0.9
