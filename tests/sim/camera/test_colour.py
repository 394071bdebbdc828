import numpy as np
import pytest

from sim.camera.colour import GAMMA, balance_rgb, black_body_xyz, light_rgb, linear_light


@pytest.mark.parametrize(
    ("temperature_K", "x", "y"),
    # CIE illuminant A is a black body of 2856 K; the others are of the Planckian locus (CIE 15).
    [(2856, 0.4476, 0.4074), (4000, 0.3805, 0.3768), (6500, 0.3135, 0.3237)],
)
def test_a_black_body_has_the_colour_that_the_cie_gives_it(temperature_K, x, y):
    xyz = black_body_xyz(temperature_K)
    np.testing.assert_allclose(xyz[:2] / xyz.sum(), [x, y], atol=0.002)


def test_light_of_6500_kelvin_changes_nothing():
    assert light_rgb(6500.0) == balance_rgb(6500.0) == (1.0, 1.0, 1.0)


def test_warm_light_is_red_and_cold_light_blue():
    for warm, cold in ((2700, 3500), (3500, 5000), (5000, 6500), (6500, 7500)):
        (r1, _, b1), (r2, _, b2) = light_rgb(warm), light_rgb(cold)
        assert r1 > r2
        assert b1 < b2


@pytest.mark.parametrize("temperature_K", [2700, 4000, 7500])
def test_light_keeps_its_brightness_and_balance_undoes_it(temperature_K):
    linear = linear_light(temperature_K)
    neutral = np.array([1.0, 1.0, 1.0])
    luminance = np.array([0.2126, 0.7152, 0.0722])  # of linear sRGB
    # White of 6500 K as a black body is not quite D65, the white of sRGB.
    assert luminance @ linear == pytest.approx(luminance @ neutral, rel=0.01)
    lit = np.array(light_rgb(temperature_K)) ** GAMMA
    np.testing.assert_allclose(lit * balance_rgb(temperature_K), 1.0, rtol=1e-12)


@pytest.mark.parametrize("temperature_K", [0.0, 1500.0, -5.0, float("nan")])
def test_a_temperature_without_colour_is_refused(temperature_K):
    with pytest.raises(ValueError, match="temperature_K must be from 2000 to 25000"):
        light_rgb(temperature_K)
