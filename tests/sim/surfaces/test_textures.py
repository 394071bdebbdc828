import numpy as np
import pytest

from sim.randomness import generator
from sim.surfaces.textures import (
    PATTERNS,
    STRIPES,
    SURFACES,
    cloth,
    painting,
    plaster,
    second_colour,
    tabletop,
    wood,
)

BLUE, BEIGE = (0.15, 0.25, 0.55), (0.72, 0.52, 0.38)


def rng(seed=100):
    return generator(seed, "texture")


@pytest.mark.parametrize("surface", SURFACES)
@pytest.mark.parametrize("rgb", [BLUE, BEIGE])
def test_a_table_top_has_the_colour_asked_for_in_the_mean(surface, rgb):
    for seed in (100, 101, 102):
        picture = tabletop(rng(seed), rgb, surface)
        np.testing.assert_allclose(picture.reshape(-1, 3).mean(axis=0) / 255, rgb, rtol=0.06)


def test_the_surfaces_look_different():
    roughness = {s: tabletop(rng(), BEIGE, s)[..., 0].std(axis=0).mean() for s in SURFACES}
    assert roughness["plain"] < roughness["cloth"]
    assert roughness["plain"] < roughness["wood"]


@pytest.mark.parametrize("pattern", PATTERNS)
def test_a_picture_depends_on_its_generator_alone(pattern):
    first, again = cloth(rng(), BLUE, pattern), cloth(rng(), BLUE, pattern)
    np.testing.assert_array_equal(first, again)
    assert (first != cloth(rng(101), BLUE, pattern)).any()


def test_stripes_run_round_and_checks_both_ways():
    plain, stripes, checks = (cloth(rng(), BLUE, p)[..., 0].astype(float) for p in PATTERNS)
    for picture, rows, columns in ((plain, 0, 0), (stripes, 1, 0), (checks, 1, 1)):
        wave = [
            np.abs(np.fft.rfft(picture.mean(axis=axis)))[STRIPES] / picture.shape[axis]
            for axis in (1, 0)
        ]
        assert (wave[0] > 8) == bool(rows)
        assert (wave[1] > 8) == bool(columns)


def test_a_third_of_the_checks_closes_round_a_sleeve():
    columns = cloth(rng(), BLUE, "checks")[..., 0].mean(axis=0)
    at = np.arange(60.0)
    there = np.interp(at + len(columns) / 3, np.arange(len(columns)), columns)
    assert np.corrcoef(columns[:60], there)[0, 1] > 0.95


def test_the_second_colour_stands_out():
    for rgb in (BLUE, BEIGE, (0.9, 0.9, 0.9), (0.05, 0.05, 0.05)):
        other = second_colour(np.array(rgb))
        assert np.abs(other - rgb).max() > 0.25
        assert other.min() >= 0
        assert other.max() <= 1


def test_the_warm_painting_is_of_skins_hues_and_the_other_is_not():
    for warm in (True, False):
        red, green, blue = painting(rng(), warm=warm).reshape(-1, 3).mean(axis=0)
        assert (red > green > blue) == warm


def test_wood_has_dark_joints_between_planks():
    rows = wood(rng(), BEIGE, planks=4, size=256)[..., 0].mean(axis=1)
    joints = [0, 64, 128, 192]
    assert rows[joints].max() < 0.85 * np.median(rows)


def test_plaster_is_nearly_even():
    picture = plaster(rng(), BEIGE)[..., 0].astype(float)
    assert 0.01 < picture.std() / picture.mean() < 0.06
