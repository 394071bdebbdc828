"""Splitting of blobs: two discs, a ring of pieces."""

from __future__ import annotations

import numpy as np

from pjpdaf.looks import looks_of_ellipses
from pjpdaf.tracker.hypotheses.split import halves, outside, pieces, settle


def disc(x: float, y: float, radius: float, step: float = 3.0) -> np.ndarray:
    grid = np.arange(-radius, radius + 1, step)
    px, py = (axis.ravel() for axis in np.meshgrid(grid, grid))
    inside = px**2 + py**2 <= radius**2
    return np.column_stack([px, py])[inside] + (x, y)


def test_halves_of_two_discs_are_their_centres():
    both = np.concatenate([disc(100, 200, 20), disc(140, 210, 20)])
    found = halves(both, together=1.0)
    assert found is not None
    centres, shares = found
    centres = centres[np.argsort(centres[:, 0])]
    # The overlap is cut down the middle: the centres move apart by less than 2 px.
    np.testing.assert_allclose(centres, [[100, 200], [140, 210]], atol=2.0)
    np.testing.assert_allclose(shares, 0.5, atol=0.03)
    assert shares.sum() == 1.0


def test_halves_drawn_together_keep_their_middle():
    both = np.concatenate([disc(100, 200, 20), disc(140, 210, 20)])
    apart, near = halves(both, 1.0), halves(both, 0.7)
    assert apart is not None
    assert near is not None
    np.testing.assert_allclose(near[0].mean(axis=0), apart[0].mean(axis=0))
    np.testing.assert_allclose(
        np.linalg.norm(near[0][1] - near[0][0]), 0.7 * np.linalg.norm(apart[0][1] - apart[0][0])
    )


def test_few_pixels_have_no_halves():
    assert halves(np.zeros((7, 2)), 0.7) is None


def test_hand_beside_a_head_is_outside_its_ellipse():
    head, hand = disc(300, 100, 40), disc(350, 120, 18)
    shape = np.eye(2) * 40.0**2 / 4
    left = outside(np.concatenate([head, hand]), np.array([300.0, 100.0]), shape, scale=1.1)
    piece, *others = pieces(left, 3.0, least=6)
    assert not others
    assert piece[:, 0].mean() > 351  # the part of the hand beyond the head
    assert len(piece) > 0.7 * len(hand)


def test_pieces_are_apart_and_sorted_by_size():
    found = pieces(np.concatenate([disc(0, 0, 9), disc(60, 0, 15), disc(120, 0, 3)]), 3.0, least=6)
    assert [round(float(p[:, 0].mean())) for p in found] == [60, 0]


def test_ellipse_settles_on_the_head_although_a_hand_hangs_on_it():
    blob = np.concatenate([disc(300, 100, 40), disc(352, 130, 18)])
    centre, inside = settle(blob, np.array([306.0, 96.0]), np.eye(2) * 40.0**2 / 4)
    np.testing.assert_allclose(centre, [300, 100], atol=4.0)
    assert inside > 0.9 * len(disc(300, 100, 40))


def test_ellipses_are_filled_with_pixels_of_one_size():
    """A head's blob has as many more pixels than a hand's as it is larger."""
    ellipses = np.array([[100.0, 100, 40, 30, 0.3], [300, 200, 22, 18, 1.0], [50, 60, 14, 6, 0]])
    looks = looks_of_ellipses(ellipses)
    for pixels, (x, y, a, b, angle) in zip(looks.pixels, ellipses, strict=True):
        np.testing.assert_allclose(pixels.mean(axis=0), (x, y), atol=0.01)
        np.testing.assert_allclose(len(pixels) * looks.pixel_area_px, np.pi * a * b, rtol=0.15)
        along = (pixels - (x, y)) @ (np.cos(angle), np.sin(angle))
        assert 0.8 * a < along.max() <= a
    assert looks_of_ellipses(np.zeros((0, 5))).pixels == ()
