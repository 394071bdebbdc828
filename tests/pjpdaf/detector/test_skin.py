"""Skin colour: range, hue across 0, learning."""

from __future__ import annotations

import colorsys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pjpdaf.detector.parameters import DetectorParameters
from pjpdaf.detector.skin import (
    HUE_STEP_DEG,
    SkinRange,
    circular_difference_deg,
    circular_mean_deg,
    learn_skin_from_head,
    learn_skin_range,
    skin_mask,
    to_hsv,
)
from pjpdaf.errors import BenchError

angles = st.floats(0, 359.99)


def bgr(hue_deg: float, saturation: float, value: float) -> np.ndarray:
    """uint8 BGR (3,) of a colour, by the standard library rather than by OpenCV."""
    rgb = colorsys.hsv_to_rgb(hue_deg / 360, saturation, value)
    return np.round(np.array(rgb[::-1]) * 255).astype(np.uint8)


def patch(hue_deg: float, saturation: float, value: float, size: int = 20) -> np.ndarray:
    return np.tile(bgr(hue_deg, saturation, value), (size, size, 1))


def is_skin(skin: SkinRange, *colour: float) -> bool:
    mask = skin_mask(to_hsv(patch(*colour)), skin)
    assert mask.dtype == np.uint8
    assert set(np.unique(mask)) <= {0, 255}
    assert mask.min() == mask.max()
    return bool(mask.max())


@pytest.mark.parametrize(
    ("interval", "inside", "outside"),
    [
        ((10, 40), (12, 25, 38), (5, 45, 200, 355)),
        ((350, 20), (352, 0, 18), (345, 25, 180)),  # across 0
        ((-10, 20), (352, 0, 18), (345, 25, 180)),  # the same, written with a negative angle
        ((340, 359), (342, 350, 357), (2, 330)),
        ((0, 360), (0, 90, 180, 359), ()),
        ((350, 370), (352, 0, 8), (12, 345)),
    ],
)
def test_hue_interval(interval, inside, outside):
    skin = SkinRange(interval, (0.2, 0.8), 0.2)
    assert [is_skin(skin, hue, 0.5, 0.8) for hue in inside] == [True] * len(inside)
    assert [is_skin(skin, hue, 0.5, 0.8) for hue in outside] == [False] * len(outside)


def test_saturation_and_value_bound_the_range():
    skin = SkinRange((0, 40), (0.2, 0.7), 0.2)
    assert is_skin(skin, 20, 0.45, 0.25)
    assert not is_skin(skin, 20, 0.15, 0.8)
    assert not is_skin(skin, 20, 0.75, 0.8)
    assert not is_skin(skin, 20, 0.45, 0.15)


@given(low=st.integers(0, 255), span=st.integers(0, 255))
def test_mask_agrees_with_a_loop_over_all_hues(low, span):
    """Each whole hue step is in exactly when it lies in the circular interval."""
    skin = SkinRange((low * HUE_STEP_DEG, (low + span) * HUE_STEP_DEG), (0, 1), 0)
    hsv = np.zeros((1, 256, 3), np.uint8)
    hsv[0, :, 0] = np.arange(256)
    expected = [(hue - low) % 256 <= span for hue in range(256)]
    np.testing.assert_array_equal(skin_mask(hsv, skin)[0] == 255, expected)


@pytest.mark.parametrize(("hue", "saturation"), [(8, 0.36), (8, 0.52), (31, 0.36), (31, 0.52)])
def test_rendered_skin_is_well_inside_the_default_range(hue, saturation):
    skin = DetectorParameters().skin
    rng = np.random.default_rng(0)
    # Below 2 deg lies what is red and white at once: lips, the print of a can. The reddest skin
    # loses a few noisy pixels to that, which the closing fills.
    for value, share in ((0.8, 0.9), (0.5, 0.8)):
        noisy = patch(hue, saturation, value, 100) + rng.normal(0, 3, (100, 100, 3))
        mask = skin_mask(to_hsv(np.clip(noisy, 0, 255).round().astype(np.uint8)), skin)
        assert (mask > 0).mean() > share


@given(st.lists(angles, min_size=1, max_size=20), angles)
def test_circular_mean_turns_with_its_angles(hues, turn):
    hues = np.array(hues)
    # Where the directions cancel, the mean is not defined.
    if np.abs(np.exp(1j * np.radians(hues)).mean()) < 1e-3:
        return
    turned = circular_mean_deg((hues + turn) % 360)
    difference = circular_difference_deg(np.array(turned - circular_mean_deg(hues)), turn)
    assert abs(float(difference)) < 1e-6


@given(angles, st.lists(st.floats(-80, 80), min_size=1, max_size=20))
def test_circular_mean_is_the_mean_within_symmetric_samples(centre, offsets):
    hues = (centre + np.array([*offsets, *(-o for o in offsets)])) % 360
    mean = circular_mean_deg(hues)
    assert 0 <= mean < 360
    assert abs(float(circular_difference_deg(np.array(mean), centre))) < 1e-6


@given(angles, angles)
def test_circular_difference_is_the_short_way(a, b):
    d = float(circular_difference_deg(np.array(a), b))
    assert -180 <= d < 180
    assert np.cos(np.radians(d)) == pytest.approx(np.cos(np.radians(a - b)), abs=1e-9)


@pytest.mark.parametrize("hue", [18, 2, 356])
def test_a_range_learnt_from_a_sample_holds_it(hue):
    rng = np.random.default_rng(1)
    sample = patch(hue, 0.45, 0.8, 60) + rng.normal(0, 5, (60, 60, 3))
    sample = np.clip(sample, 0, 255).round().astype(np.uint8)
    skin = learn_skin_range(sample)
    assert (skin_mask(to_hsv(sample), skin) > 0).mean() > 0.97
    assert skin.hue_span_deg < 30
    assert not is_skin(skin, hue + 60, 0.45, 0.8)
    assert not is_skin(skin, hue, 0.9, 0.8)


def test_a_mask_picks_the_sample():
    picture = patch(200, 0.8, 0.8, 60)
    picture[10:40, 10:40] = bgr(20, 0.4, 0.7)
    mask = np.zeros((60, 60), bool)
    mask[10:40, 10:40] = True
    skin = learn_skin_range(picture, mask)
    assert is_skin(skin, 20, 0.4, 0.7)
    assert not is_skin(skin, 200, 0.8, 0.8)


def test_skin_from_the_head_of_the_first_frames():
    picture = patch(220, 0.3, 0.5, 200)
    picture[20:70, 80:120] = bgr(14, 0.5, 0.8)  # head
    picture[150:180, 20:60] = bgr(45, 0.7, 0.6)  # something else of a broad skin colour, lower
    broad = SkinRange((340, 60), (0.1, 0.9), 0.2)
    skin = learn_skin_from_head([patch(220, 0.3, 0.5, 200), picture], broad)
    assert is_skin(skin, 14, 0.5, 0.8)
    assert not is_skin(skin, 45, 0.7, 0.6)
    nothing = np.zeros((200, 200), np.uint8)
    with pytest.raises(BenchError, match="No region of at least 500 px"):
        learn_skin_from_head([picture], broad, foreground=[nothing])


def test_bad_samples_are_refused():
    with pytest.raises(BenchError, match="at least 50 coloured pixels, got 0"):
        learn_skin_range(np.full((20, 20, 3), 128, np.uint8))
    with pytest.raises(BenchError, match=r"uint8 BGR picture \(h, w, 3\), got float64"):
        learn_skin_range(np.zeros((20, 20, 3)))
    with pytest.raises(BenchError, match=r"size \(20, 20\), got \(3, 3\)"):
        learn_skin_range(patch(20, 0.5, 0.5), np.ones((3, 3)))
