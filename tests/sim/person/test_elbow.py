"""The elbow: frames share the hinge, and the cloth's stripes run on round the bend."""

import numpy as np
from scipy.spatial.transform import Rotation

from sim.person.cloth import SHIRT_M
from sim.person.elbow import hinged, sleeve_above, sleeve_below
from sim.surfaces.shapes import limb

LENGTH_M, RADIUS_M = 0.25, 0.043


def test_both_bones_keep_their_way_and_share_the_hinge():
    turns = Rotation.random(40, rng=np.random.default_rng(5)).as_matrix()
    for upper, fore in turns.reshape(20, 2, 3, 3):
        above, below = hinged(upper, fore)
        for frame, bone in ((above, upper), (below, fore)):
            np.testing.assert_allclose(frame[:, 0], bone[:, 0], atol=1e-12)
            np.testing.assert_allclose(frame.T @ frame, np.eye(3), atol=1e-12)
            assert np.linalg.det(frame) > 0
        np.testing.assert_allclose(above[:, 1], below[:, 1], atol=1e-12)
        # The forearm bends away from +z of the upper arm.
        assert fore[:, 0] @ above[:, 2] < 0


def test_a_straight_arm_keeps_its_frames():
    upper = Rotation.from_euler("xyz", [0.3, 0.2, 0.1]).as_matrix()
    fore = upper @ Rotation.from_euler("x", 0.7).as_matrix()
    above, below = hinged(upper, fore)
    np.testing.assert_array_equal(above, upper)
    np.testing.assert_array_equal(below, fore)


def test_stripes_meet_at_the_elbow_and_turn_about_its_hinge():
    radii = np.full(5, RADIUS_M)
    above = sleeve_above(limb(LENGTH_M, radii), LENGTH_M)
    below = sleeve_below(limb(LENGTH_M, radii), RADIUS_M)
    for surface, at_elbow in ((above, LENGTH_M), (below, 0.0)):
        ring = np.abs(surface.vertices_m[:, 0] - at_elbow) < 1e-9
        np.testing.assert_allclose(surface.uv[ring, 1], 1.0, atol=1e-12)
    x, _, z = below.vertices_m.T
    end = (x < -1e-6) & (np.hypot(x, z) > 1e-6)
    # In a plane through the hinge (y) all of the round end has the same place along the sleeve.
    angle = np.arctan2(-x[end], np.abs(z[end]))
    np.testing.assert_allclose(below.uv[end, 1] - 1.0, RADIUS_M * angle / SHIRT_M, atol=1e-9)
    # Below the elbow it runs on at the cloth's own scale.
    body = x > 1e-6
    np.testing.assert_allclose(1.0 - below.uv[body, 1], x[body] / SHIRT_M, atol=1e-9)
