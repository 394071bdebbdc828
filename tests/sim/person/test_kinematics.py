"""Arms: closed form closes, limits hold, frames are the documented ones."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim.anatomy import Anatomy
from sim.person.kinematics import (
    MAX_EXTENSION_RAD,
    MAX_STRETCH,
    MAX_SWIVEL_RAD,
    MAX_WRIST_BEND_RAD,
    OUTWARD,
    elbow_circle,
    elbow_flexion,
    hand_rotation,
    reach_limits,
    shoulder_angles,
    shoulders,
    solve_arm,
    within_reach,
    wrist_bend,
)
from sim.vectors import about, about_x, about_y, about_z, bone_frame, norm

PERSON = Anatomy.of(1.72)
SHOULDER = np.array([0.0, -0.186, 0.994])
ACROSS = SHOULDER + np.array([0.30, 0.30, 0.0])

offsets = st.tuples(st.floats(-1.2, 1.2), st.floats(-1.2, 1.2), st.floats(-1.2, 1.2)).map(np.array)
angles = st.floats(-1.0, 1.0)
sides = st.sampled_from([0, 1])


@given(side=sides, offset=offsets, swivel=st.floats(0.0, MAX_SWIVEL_RAD))
def test_bones_close_to_a_nanometre(side, offset, swivel):
    a, b = PERSON.upper_arm_m, PERSON.forearm_m
    wrist = within_reach(SHOULDER, SHOULDER + offset, a, b)
    elbow = elbow_circle(side, SHOULDER, wrist, a, b).elbow(swivel)
    assert norm(elbow - SHOULDER) == pytest.approx(a, abs=1e-9)
    assert norm(wrist - elbow) == pytest.approx(b, abs=1e-9)


@given(side=sides, offset=offsets, yaw=angles, pitch=angles, roll=angles)
def test_arm_forward_from_its_frames_gives_its_joints(side, offset, yaw, pitch, roll):
    hand = hand_rotation(side, yaw, pitch, roll)
    arm = solve_arm(PERSON, side, SHOULDER, SHOULDER + offset, hand, 0.5)
    elbow = SHOULDER + PERSON.upper_arm_m * arm.upper_arm[:, 0]
    wrist = elbow + PERSON.forearm_m * arm.forearm[:, 0]
    palm = wrist + PERSON.wrist_to_palm_m * arm.hand[:, 0]
    np.testing.assert_allclose(elbow, arm.elbow_m, atol=1e-9)
    np.testing.assert_allclose(wrist, arm.wrist_m, atol=1e-9)
    np.testing.assert_allclose(palm, arm.palm_m, atol=1e-9)
    for rotation in (arm.upper_arm, arm.forearm, arm.hand):
        np.testing.assert_allclose(rotation.T @ rotation, np.eye(3), atol=1e-9)
        assert np.linalg.det(rotation) == pytest.approx(1.0, abs=1e-9)


@given(offset=offsets)
def test_no_arm_is_stretched_or_folded_past_its_limits(offset):
    a, b = PERSON.upper_arm_m, PERSON.forearm_m
    arm = solve_arm(PERSON, 0, SHOULDER, SHOULDER + offset, np.eye(3), 0.5)
    least, most = reach_limits(a, b)
    assert most == pytest.approx(MAX_STRETCH * (a + b))
    assert least - 1e-9 <= norm(arm.wrist_m - SHOULDER) <= most + 1e-9


def test_a_target_within_reach_is_reached_exactly():
    palm = SHOULDER + np.array([0.35, 0.0, -0.2])
    arm = solve_arm(PERSON, 0, SHOULDER, palm, hand_rotation(0, 0.3, 0.1, 0.0), 0.5)
    np.testing.assert_allclose(arm.palm_m, palm, atol=1e-12)
    assert arm.short_m == pytest.approx(0.0, abs=1e-12)


def test_a_target_out_of_reach_is_pulled_in_and_the_shortfall_told():
    arm = solve_arm(PERSON, 0, SHOULDER, SHOULDER + np.array([1.0, 0.0, 0.0]), np.eye(3), 0.5)
    most = MAX_STRETCH * (PERSON.upper_arm_m + PERSON.forearm_m) + PERSON.wrist_to_palm_m
    assert norm(arm.palm_m - SHOULDER) == pytest.approx(most, abs=1e-9)
    assert arm.short_m == pytest.approx(1.0 - most, abs=1e-9)


@given(
    side=sides,
    x=st.floats(0.2, 0.45),
    y=st.floats(-0.15, 0.15),
    z=st.floats(-0.25, 0.15),
    yaw=angles,
    pitch=angles,
)
def test_the_wrist_never_bends_further_than_a_wrist_can(side, x, y, z, yaw, pitch):
    palm = SHOULDER + np.array([x, y, z])
    arm = solve_arm(PERSON, side, SHOULDER, palm, hand_rotation(side, yaw, pitch, 0.0), 0.5)
    bend = math.acos(np.clip(arm.forearm[:, 0] @ arm.hand[:, 0], -1, 1))
    # The iteration ends within 3 degrees of the limit.
    assert bend <= MAX_WRIST_BEND_RAD + math.radians(3.0)


@pytest.mark.parametrize("side", [0, 1])
def test_swivel_takes_the_elbow_outward_and_zero_hangs_it_down(side):
    wrist = SHOULDER + np.array([0.35, 0.0, -0.1])
    circle = elbow_circle(side, SHOULDER, wrist, PERSON.upper_arm_m, PERSON.forearm_m)
    lowest = circle.elbow(0.0)
    assert lowest[1] == pytest.approx(SHOULDER[1], abs=1e-9)
    assert lowest[2] < min(circle.elbow(s)[2] for s in (0.3, 0.6, 0.9))
    assert (circle.elbow(0.5)[1] - SHOULDER[1]) * OUTWARD[side] > 0.05


@given(height=st.floats(0.6, 1.2))
def test_the_elbow_is_kept_above_a_height_where_that_is_possible(height):
    wrist = SHOULDER + np.array([0.35, 0.0, -0.2])
    circle = elbow_circle(0, SHOULDER, wrist, PERSON.upper_arm_m, PERSON.forearm_m)
    swivel = circle.least_swivel(height)
    possible = circle.elbow(MAX_SWIVEL_RAD)[2]
    assert circle.elbow(swivel)[2] >= min(height, possible) - 1e-9
    if 0.0 < swivel < MAX_SWIVEL_RAD:
        assert circle.elbow(swivel)[2] == pytest.approx(height, abs=1e-9)


@given(side=sides, offset=offsets, swivel=st.floats(0.0, MAX_SWIVEL_RAD))
def test_an_arm_tells_its_swivel_and_how_its_elbow_swings_with_it(side, offset, swivel):
    arms = [
        solve_arm(PERSON, side, SHOULDER, SHOULDER + offset, np.eye(3), turned)
        for turned in (swivel, swivel + 1e-5)
    ]
    assert arms[0].swivel_rad == swivel
    if np.abs(arms[0].hand - np.eye(3)).max() < 1e-12:  # a wrist at its limit turns the hand too
        swung = (arms[1].elbow_m - arms[0].elbow_m) / 1e-5
        np.testing.assert_allclose(swung, arms[0].swing, atol=1e-4)


@pytest.mark.long
def test_the_elbow_follows_the_wrist_without_a_jump_wherever_a_hand_goes():
    """Paths of the wrist about a shoulder, also beside and behind the head and behind the back."""
    a, b = PERSON.upper_arm_m, PERSON.forearm_m
    rng = np.random.default_rng(5)
    step_m = 0.001
    for side in (0, 1):
        for _ in range(60):
            ends = rng.uniform([-0.2, -0.35, -0.35], [0.45, 0.35, 0.4], (2, 3))
            count = max(int(norm(ends[1] - ends[0]) / step_m), 2)
            last = None
            for share in np.linspace(0.0, 1.0, count):
                offset = ends[0] + share * (ends[1] - ends[0])
                axis = offset / max(norm(offset), 1e-9)
                inward = -OUTWARD[side] * axis[1]
                wrist = within_reach(SHOULDER, SHOULDER + offset, a, b)
                elbow = elbow_circle(side, SHOULDER, wrist, a, b).elbow(0.6)
                # Where no hand can go: through the back, inward or straight behind the hip.
                impossible = axis[0] < -0.2 and (inward > 0.2 or axis[2] < -0.5)
                close = norm(offset) < 0.2
                if last is not None and not impossible and not close:
                    assert norm(elbow - last) < 0.02
                last = elbow


def test_a_hand_behind_the_head_has_its_elbow_up_and_out():
    for side in (0, 1):
        wrist = SHOULDER + np.array([-0.12, -OUTWARD[side] * 0.15, 0.25])
        circle = elbow_circle(side, SHOULDER, wrist, PERSON.upper_arm_m, PERSON.forearm_m)
        elbow = circle.elbow(0.5) - SHOULDER
        assert elbow[1] * OUTWARD[side] > 0.08
        assert elbow[2] > 0.10


def test_the_shoulder_is_not_taken_further_back_than_it_goes():
    forward = np.array([1.0, 0.0, 0.0])
    palm = SHOULDER + np.array([0.0, 0.0, -0.25])  # a hand at the side of the belly
    hand = hand_rotation(0, 0.0, 0.8, 0.0)
    free = solve_arm(PERSON, 0, SHOULDER, palm, hand, 0.1)
    kept = solve_arm(PERSON, 0, SHOULDER, palm, hand, 0.1, forward=forward)
    assert shoulder_angles(0, np.eye(3), free)[0] > MAX_EXTENSION_RAD
    assert shoulder_angles(0, np.eye(3), kept)[0] <= MAX_EXTENSION_RAD
    assert (kept.elbow_m[1] - free.elbow_m[1]) * OUTWARD[0] > 0.02
    np.testing.assert_allclose(kept.palm_m, free.palm_m, atol=0.002)


def test_joint_angles_are_those_of_known_poses():
    wrist = SHOULDER + np.array([0.0, 0.0, -0.3])
    hanging = solve_arm(PERSON, 0, SHOULDER, wrist, np.eye(3), 0.0)
    extension, adduction = shoulder_angles(0, np.eye(3), hanging)
    assert extension > 0.4  # the elbow is behind a hand at the hip
    assert abs(adduction) < 0.05
    # Law of cosines between upper arm and forearm.
    a, b = PERSON.upper_arm_m, PERSON.forearm_m
    d = norm(hanging.wrist_m - SHOULDER)
    inner = math.acos((a * a + b * b - d * d) / (2 * a * b))
    assert elbow_flexion(hanging) == pytest.approx(math.pi - inner, abs=1e-9)
    straight = hanging.forearm[:, 0] @ hanging.hand[:, 0]
    assert wrist_bend(hanging) == pytest.approx(math.acos(straight), abs=1e-9)
    across = solve_arm(PERSON, 0, SHOULDER, ACROSS, np.eye(3), 0.5)
    assert shoulder_angles(0, np.eye(3), across)[1] > 0.2
    # A torso turned along leaves the joint where it was.
    turn = about_z(0.4)
    moved = solve_arm(PERSON, 0, SHOULDER, SHOULDER + turn @ (ACROSS - SHOULDER), turn, 0.5)
    assert shoulder_angles(0, turn, moved)[1] == pytest.approx(
        shoulder_angles(0, np.eye(3), across)[1], abs=1e-6
    )


def test_hand_frames_are_those_of_the_pose():
    for side, thumb in ((0, 1.0), (1, -1.0)):
        flat = hand_rotation(side, 0.0, 0.0, 0.0)
        np.testing.assert_allclose(flat, np.eye(3), atol=1e-12)  # fingers forward, back of hand up
        inwards = hand_rotation(side, 0.5, 0.0, 0.0)[:, 0]
        assert inwards[1] * OUTWARD[side] < 0
        assert hand_rotation(side, 0.0, 0.5, 0.0)[2, 0] < 0  # tips dip
        thumb_up = hand_rotation(side, 0.0, 0.0, math.pi / 2) @ np.array([0.0, thumb, 0.0])
        np.testing.assert_allclose(thumb_up, [0.0, 0.0, 1.0], atol=1e-12)


@given(x=offsets.filter(lambda v: norm(v) > 1e-3))
def test_bone_frames_point_along_the_bone_with_z_up(x):
    frame = bone_frame(np.zeros(3), x)
    np.testing.assert_allclose(frame[:, 0], x / norm(x), atol=1e-12)
    np.testing.assert_allclose(np.cross(frame[:, 0], frame[:, 1]), frame[:, 2], atol=1e-12)
    assert frame[2, 2] >= -1e-6  # nearer than that to upright, z points back or forward


def test_a_wrist_at_its_limit_turns_the_hand_without_a_step():
    """A hand dipped further and further is turned back by what is too much, from nothing."""
    joint, palm = np.array([0.0, -0.19, 1.0]), np.array([0.3, -0.2, 0.95])
    turned = []
    for dip in np.arange(-0.3, 0.6, 1e-3).tolist():
        wanted = hand_rotation(0, 0.0, dip, 0.0)
        hand = solve_arm(PERSON, 0, joint, palm, wanted, 0.5).hand
        turned.append(math.acos(min(1.0, 0.5 * (float(np.trace(hand.T @ wanted)) - 1.0))))
    assert turned[0] < 1e-6
    assert turned[-1] > 0.2
    assert np.abs(np.diff(turned)).max() < 2.5e-3


def test_rotation_about_an_axis_agrees_with_the_plain_ones():
    for axis, plain in ((0, about_x), (1, about_y), (2, about_z)):
        np.testing.assert_allclose(about(np.eye(3)[axis], 0.7), plain(0.7), atol=1e-12)


def test_shoulders_sit_below_and_beside_the_mid_shoulder_point():
    right, left = shoulders(PERSON, np.array([0.0, 0.0, 1.0]), np.eye(3))
    half, drop = PERSON.shoulder_half_breadth_m, PERSON.shoulder_drop_m
    np.testing.assert_allclose(right, [0.0, -half, 1.0 - drop])
    np.testing.assert_allclose(left, [0.0, half, 1.0 - drop])
