"""Edges and creases between pixels."""

import numpy as np
import pytest

from sim.dataset.check.frame.pixel_rays import bends, most, sample, straight


def test_a_plane_bends_nowhere_and_an_edge_only_beside_it():
    ys, xs = np.mgrid[:9, :12].astype(float)
    plane = 0.3 + 0.01 * xs - 0.02 * ys
    np.testing.assert_allclose(bends(plane), 0, atol=1e-12)
    stepped = plane + 0.1 * (xs > 5)
    beside = np.zeros((9, 12), bool)
    beside[:, 5:7] = True
    np.testing.assert_array_equal(bends(stepped) > 1e-6, beside)


def test_pixels_beside_a_gap_are_no_surface():
    values = np.ones((5, 5))
    values[2, 2] = np.nan
    cross = np.zeros((5, 5), bool)
    cross[2, 1:4] = cross[1:4, 2] = True
    np.testing.assert_array_equal(np.isinf(bends(values))[1:4, 1:4], cross[1:4, 1:4])


@pytest.mark.parametrize("bend", [0.0, 0.05, 0.5, 5.0])
def test_a_value_between_pixels_is_off_by_no_more_than_their_bends(bend):
    """A crease at an unknown place between two columns."""
    rng = np.random.default_rng(3)
    crease = rng.uniform(4, 5, 50)
    xs = np.arange(10.0)
    at = np.column_stack([rng.uniform(4, 5, 50), np.full(50, 2.5)])
    for x, place in zip(crease, at, strict=True):
        picture = np.tile(np.maximum(xs - x, 0) * bend, (6, 1))
        off = abs(sample(picture, place[None])[0] - max(place[0] - x, 0) * bend)
        assert off <= bends(picture)[2:4, 4:6].max() + 1e-12


def test_places_across_an_edge_are_not_straight():
    places = np.dstack(np.meshgrid(np.arange(10.0), np.arange(8.0)))
    places[:, 5:, 0] += 0.7
    at = np.array([[2.5, 3.5], [4.5, 3.5], [7.5, 3.5]])
    np.testing.assert_array_equal(straight(places, at), [True, False, True])


def test_where_most_are_edges_all_are_compared():
    few = np.arange(10) < 4
    assert most(few).all()
    np.testing.assert_array_equal(most(~few), ~few)
