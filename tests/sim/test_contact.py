"""Contact: analytic gaps against a slow second implementation, and the projection."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sim.anatomy import Anatomy
from sim.contact import (
    Capsules,
    Ellipsoid,
    Obstacles,
    Table,
    Unposable,
    capsule_gap,
    hand_capsules,
    head_ellipsoid,
    height_above_table,
    penetration,
    separate,
    torso_ellipsoids,
)
from sim.kinematics import hand_rotation, shoulders, solve_arm

PERSON = Anatomy.of(1.72)
CURLS = np.full((2, 5), 0.12)
TORSO = np.array([0.0, 0.0, PERSON.mid_shoulder_height_m])
JOINTS = shoulders(PERSON, TORSO, np.eye(3))
TABLE = Table(top_m=0.73, near_x_m=0.16, far_x_m=0.9, half_width_m=0.75)
HEAD = np.array([0.02, 0.0, 1.23])
SOLIDS = (
    head_ellipsoid(PERSON, HEAD, np.eye(3)),
    *torso_ellipsoids(PERSON, TORSO, np.eye(3)),
)
ALL = Obstacles(TABLE, SOLIDS)


def solver(yaw=0.3, pitch=0.0, roll=0.0):
    def solve(side, palm):
        hand = hand_rotation(side, yaw, pitch, roll)
        return solve_arm(PERSON, side, JOINTS[side], palm, hand, 0.5)

    return solve


points = st.tuples(*[st.floats(-0.1, 0.1)] * 3).map(np.array)


@settings(max_examples=40)
@given(a=points, b=points, c=points, d=points)
def test_gap_of_two_bars_agrees_with_dense_sampling(a, b, c, d):
    b, d = b + np.array([0.05, 0.0, 0.0]), d + np.array([0.0, 0.05, 0.0])
    radius = np.array([0.01])
    depth, _ = capsule_gap(Capsules(a[None], b[None], radius), Capsules(c[None], d[None], radius))
    s = np.linspace(0, 1, 201)[:, None]
    first, second = a + s * (b - a), c + s * (d - c)
    least = np.linalg.norm(first[:, None] - second[None], axis=2).min()
    # Samples are up to 2 mm apart, so the sampled distance is at most that much too long.
    assert 0.02 - depth <= least + 1e-9
    assert 0.02 - depth >= least - 0.002


def test_the_way_out_leads_from_the_second_to_the_first():
    low = Capsules(np.array([[0.0, 0, 0]]), np.array([[0.1, 0, 0]]), np.array([0.01]))
    high = Capsules(
        np.array([[0.05, -0.1, 0.015]]), np.array([[0.05, 0.1, 0.015]]), np.array([0.01])
    )
    depth, way = capsule_gap(high, low)
    assert depth == pytest.approx(0.005)
    np.testing.assert_allclose(way, [0, 0, 1], atol=1e-12)


def test_an_ellipsoid_is_exact_where_a_bar_just_touches_it():
    solid = Ellipsoid(np.zeros(3), np.array([0.1, 0.2, 0.3]), np.eye(3))
    for axis, size in enumerate((0.1, 0.2, 0.3)):
        at = np.zeros((1, 3))
        at[0, axis] = size + 0.01 - 0.002
        depth, way = solid.push(Capsules(at, at, np.array([0.01])))
        assert depth == pytest.approx(0.002, abs=1e-6)
        np.testing.assert_allclose(way, np.eye(3)[axis], atol=1e-9)
    far = np.full((1, 3), 1.0)
    assert solid.push(Capsules(far, far, np.array([0.01])))[0] < 0


def test_hands_mirror_each_other():
    right, left = (hand_capsules(PERSON, side, CURLS[0]) for side in (0, 1))
    np.testing.assert_allclose(right.ends_m * [1, -1, 1], left.ends_m)
    assert right.ends_m[4:7, 1].mean() > 0  # the right thumb is at +y
    # From wrist to middle finger tip: the length of the hand.
    reach = (right.ends_m[:, 0] + right.radii_m).max() + PERSON.wrist_to_palm_m
    assert reach == pytest.approx(PERSON.hand_length_m, abs=0.012)


def test_curling_brings_the_finger_tips_under_the_palm():
    flat, fist = (hand_capsules(PERSON, 0, np.full(5, c)) for c in (0.0, 1.0))
    assert fist.ends_m[7:, 0].max() < flat.ends_m[7:, 0].max() - 0.05
    assert fist.ends_m[7:, 2].min() < -0.03


def test_a_hand_laid_at_its_height_touches_the_table():
    rotation = hand_rotation(0, 0.3, 0.12, 0.1)
    height = height_above_table(PERSON, 0, rotation, CURLS[0])
    bars = hand_capsules(PERSON, 0, CURLS[0]).placed(np.array([0.4, -0.2, 0.73 + height]), rotation)
    assert TABLE.penetration(bars) == pytest.approx(0.0, abs=1e-12)
    outside = hand_capsules(PERSON, 0, CURLS[0]).placed(np.array([-0.2, -0.2, 0.5]), rotation)
    assert TABLE.penetration(outside) < 0  # under the table's height, but not over the table


def test_hands_in_the_table_are_lifted_out_of_it():
    arms = separate(
        PERSON, (np.array([0.4, -0.2, 0.70]), np.array([0.4, 0.2, 0.72])), solver(), CURLS, ALL
    )
    left = penetration(PERSON, arms, CURLS, ALL)
    assert left.worst_m <= 0.005
    assert arms[0].palm_m[2] < 0.78  # lifted, not thrown


@pytest.mark.parametrize("gap_m", [0.0, 0.01, 0.03, 0.06])
def test_hands_in_each_other_are_taken_apart_both_alike(gap_m):
    palms = (np.array([0.35, -gap_m / 2, 0.95]), np.array([0.35, gap_m / 2, 0.95]))
    arms = separate(PERSON, palms, solver(yaw=0.1, roll=1.4), CURLS, ALL)
    assert penetration(PERSON, arms, CURLS, ALL).hands_m <= 0.005
    assert arms[0].palm_m[1] < arms[1].palm_m[1]
    assert abs(arms[0].palm_m[1] + arms[1].palm_m[1]) < 0.02


def test_a_hand_in_the_face_is_put_before_it():
    palms = (np.array([0.06, 0.0, 1.22]), np.array([0.4, 0.2, 0.8]))
    arms = separate(PERSON, palms, solver(yaw=1.2, pitch=-0.4, roll=1.3), CURLS, ALL)
    assert penetration(PERSON, arms, CURLS, ALL).solids_m <= 0.005
    assert arms[0].palm_m[0] > 0.06


def test_hands_that_are_clear_are_left_where_they_are():
    palms = (np.array([0.35, -0.2, 0.9]), np.array([0.35, 0.2, 0.9]))
    arms = separate(PERSON, palms, solver(), CURLS, ALL)
    np.testing.assert_array_equal([a.palm_m for a in arms], list(palms))


def test_what_cannot_be_taken_apart_is_rejected_with_its_size():
    walls = Obstacles(TABLE, (Ellipsoid(JOINTS[0], np.full(3, 2.0), np.eye(3)),))
    palms = (np.array([0.35, -0.2, 0.9]), np.array([0.35, 0.2, 0.9]))
    with pytest.raises(Unposable, match=r"hands overlap by \d+\.\d mm after contact projection"):
        separate(PERSON, palms, solver(), CURLS, walls)
