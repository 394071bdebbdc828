"""Walls and floors: at their scale, of their colour, from their generator alone."""

import numpy as np
import pytest

from sim.surfaces.picture_textures import outdoors, portrait, print_, screen
from sim.surfaces.wall_textures import FLOORS, WALLS

SIZE_M = (2.6, 4.0)
RGB = (0.55, 0.50, 0.62)
PAINTERS = {**WALLS, **FLOORS}
PICTURES = {"outdoors": outdoors, "print": print_, "screen": screen}


@pytest.mark.parametrize("name", PAINTERS)
def test_a_surface_is_that_of_its_generator(name):
    def painted(seed):
        return PAINTERS[name](np.random.default_rng(seed), RGB, SIZE_M)

    first = painted(1)
    assert first.dtype == np.uint8
    assert first.shape[2] == 3
    assert first.shape[1] / first.shape[0] == pytest.approx(SIZE_M[1] / SIZE_M[0], rel=0.01)
    assert (painted(1) == first).all()
    assert (painted(2) != first).any()
    assert first.std() > 2
    # Nothing is drawn at the ends of the scale: it would lose its grain in the light.
    assert (first == 255).mean() < 0.02
    assert (first == 0).mean() < 0.02


def test_paint_has_the_colour_of_the_wall():
    plain = [WALLS["paint"](np.random.default_rng(seed), RGB, (1.0, 1.0)) for seed in range(3)]
    for picture in plain:
        middle = picture[60:140, 60:140].reshape(-1, 3).mean(axis=0) / 255
        np.testing.assert_allclose(middle, RGB, atol=0.08)


@pytest.mark.parametrize("name", PICTURES)
def test_a_picture_differs_from_seed_to_seed_and_is_no_flat_field(name):
    first, other = (PICTURES[name](np.random.default_rng(seed)) for seed in (1, 2))
    assert first.shape == other.shape
    assert (first != other).mean() > 0.1
    assert first.std() > 5


def test_a_portrait_has_skin_in_the_middle_of_its_upper_half():
    skin = (0.84, 0.58, 0.45)
    picture = portrait(np.random.default_rng(3), skin) / 255
    height, width = picture.shape[:2]
    cheek = picture[int(0.47 * height), width // 2 - width // 9 : width // 2 + width // 9]
    np.testing.assert_allclose(cheek.mean(axis=0), skin, atol=0.12)
