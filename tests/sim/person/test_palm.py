"""The palm: a closed surface on its own distance field, with knuckles and webs."""

import numpy as np

from sim.anatomy import Anatomy
from sim.contact.arm_shape import hand_capsules
from sim.person.hand import fingers, palm_surface
from sim.person.palm import distance, palm_grid

AVERAGE, CURLS = Anatomy.of(1.72), np.full(5, 0.1)


def test_all_points_lie_on_the_surface_of_the_blend():
    # Steps of a distance that is a lower bound only approach it: a tenth of a millimetre.
    assert np.abs(distance(palm_grid().reshape(-1, 3))).max() < 1.5e-4


def test_the_surface_is_closed_and_faces_outwards():
    surface = palm_surface(AVERAGE)
    points = surface.vertices_m[surface.faces]
    # The volume by the divergence theorem: positive only if faces look outwards.
    volume = np.einsum("ij,ij->i", points[:, 0], np.cross(points[:, 1], points[:, 2])).sum() / 6
    assert 1.2e-4 < volume < 3.5e-4
    _, vertex = np.unique(surface.vertices_m.round(9), axis=0, return_inverse=True)
    edges = vertex[surface.faces][:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    edges = edges[edges[:, 0] != edges[:, 1]]
    _, count = np.unique(np.sort(edges, axis=1), axis=0, return_counts=True)
    assert (count == 2).all()


def test_every_first_joint_of_a_finger_lies_within_the_palm_and_knuckles_rise_over_it():
    for finger in fingers(AVERAGE)[1:]:
        assert distance(finger.base_m[None])[0] < -0.005
    heights = []
    for y in (0.030, 0.020, 0.010, 0.0, -0.0105):  # knuckle, valley, knuckle, valley, knuckle
        z = np.linspace(0.0, 0.03, 600)
        line = np.column_stack([np.full_like(z, 0.024), np.full_like(z, y), z])
        heights.append(z[np.argmax(distance(line) > 0)])
    assert heights[0] > heights[1] + 0.0005
    assert heights[1] + 0.0005 < heights[2] > heights[3] + 0.0005
    assert heights[4] > heights[3]


def test_webs_reach_between_the_fingers_but_less_far_than_halfway_to_the_next_joint():
    index, middle = fingers(AVERAGE)[1:3]
    between = (index.base_m + middle.base_m) / 2
    ahead = np.linspace(0.0, 0.03, 300)
    line = between + np.column_stack([ahead, 0 * ahead, -0.004 + 0 * ahead])
    reach = ahead[np.argmax(distance(line) > 0)]
    assert 0.004 < reach < 0.5 * index.lengths_m[0]


def test_the_drawn_palm_is_within_a_few_millimetres_of_the_bars_that_stand_for_it():
    """Contact and the fast mode's outlines know palm and thumb as bars."""
    for anatomy in (AVERAGE, Anatomy.of(1.60, hand_scale=1.08)):
        points, bars = palm_surface(anatomy).vertices_m, hand_capsules(anatomy, 0, CURLS)
        points = points[(points[:, 0] > -0.05) & (points[:, 0] < 0.015)]
        along = bars.ends_m - bars.starts_m
        share = ((points[:, None] - bars.starts_m) * along).sum(-1) / (along**2).sum(-1)
        nearest = bars.starts_m + np.clip(share, 0, 1)[..., None] * along
        gaps = np.linalg.norm(points[:, None] - nearest, axis=-1) - bars.radii_m
        beyond = gaps.min(axis=1)
        assert beyond.max() < 0.0065  # the web of the thumb
        assert np.abs(np.median(beyond)) < 0.003
