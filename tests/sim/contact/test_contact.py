"""Contact: gaps against slow second implementations and drawn surfaces, and the projection."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from scenarios.spec.draw import perform
from scenarios.spec.names import load_scenario
from sim.anatomy import Anatomy
from sim.contact.arm_shape import (
    FOREARM,
    HAND,
    PART_OF_BAR,
    PART_OF_POINT,
    arm_shape,
    hand_capsules,
    height_above_table,
)
from sim.contact.capsules import Capsules, capsule_gap, contacts, overlaps
from sim.contact.contact import penetration
from sim.contact.separation import separate
from sim.contact.solids import Obstacles, Slab, StandingObject, Table, person_solids
from sim.gl import load_mujoco
from sim.person.geoms import SKIN
from sim.person.head import head_surface
from sim.person.kinematics import hand_rotation, shoulders, solve_arm
from sim.person.torso import torso_surface
from sim.pose import SIDES
from sim.scene.world import build
from sim.specs import SceneSpec
from sim.vectors import norm

mujoco = load_mujoco()
PERSON = Anatomy.of(1.72)
CURLS = np.full((2, 5), 0.12)
TORSO = np.array([0.0, 0.0, PERSON.mid_shoulder_height_m])
HEAD = np.array([0.02, 0.0, 1.23])
JOINTS = shoulders(PERSON, TORSO, np.eye(3))
TABLE = Table(top_m=0.73, near_x_m=0.16, far_x_m=0.9, half_width_m=0.75, thickness_m=0.028)
ALL = Obstacles(TABLE, person_solids(PERSON, TORSO, np.eye(3), HEAD, np.eye(3)))
REST = (np.array([0.35, -0.22, 0.80]), np.array([0.35, 0.22, 0.80]))
LOW_TABLE = Table(top_m=0.5, near_x_m=0.16, far_x_m=0.9, half_width_m=0.75, thickness_m=0.028)
DEEPEST_M = 0.002  # aim of the projection; 5 mm are allowed


def test_pairs_in_contact_are_those_of_all_pairs():
    rng = np.random.default_rng(0)
    some = 0
    for _ in range(50):
        a, b = (
            Capsules(at, at + 0.1 * rng.standard_normal((n, 3)), 0.05 * rng.random(n))
            for n in (25, 20)
            for at in [0.2 * rng.standard_normal((n, 3))]
        )
        counts, least_m = rng.random((25, 20)) < 0.8, 0.002
        overlap, distance, between = overlaps(a, b)
        met = contacts(a, b, least_m, counts)
        i, j = np.nonzero((overlap > least_m) & counts)
        assert np.array_equal(met.i, i)
        assert np.array_equal(met.j, j)
        assert np.array_equal(met.overlap_m, overlap[i, j])  # to the bit
        assert np.array_equal(met.distance_m, distance[i, j])
        assert np.array_equal(met.between, between[i, j])
        some += len(i)
    assert some > 100


def solver(yaw=0.3, pitch=0.0, roll=0.0, swivel=0.5):
    def solve(side, palm, swivel_rad):
        hand = hand_rotation(side, yaw, pitch, roll)
        turned = swivel if swivel_rad is None else swivel_rad
        return solve_arm(PERSON, side, JOINTS[side], palm, hand, turned)

    return solve


def depth_of(points, radii, bars):
    """Deepest of round points in round bars, by sampling the bars densely."""
    s = np.linspace(0, 1, 101)[:, None, None]
    axis = bars.starts_m + s * (bars.ends_m - bars.starts_m)
    gap = np.linalg.norm(points[:, None, None] - axis, axis=-1) - bars.radii_m
    return radii - gap.min(axis=(1, 2))


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


@pytest.mark.parametrize("kind", ["box", "cylinder"])
def test_distance_to_boxes_and_cylinders_agrees_with_mujoco(kind):
    """mj_geomDistance of a small ball, turned 0.4 rad about the vertical."""
    size = "0.05 0.08 0.12" if kind == "box" else "0.05 0.12"
    model = mujoco.MjModel.from_xml_string(
        f"""<mujoco><worldbody>
          <geom name="thing" type="{kind}" size="{size}" pos="0.3 0.1 0.92" euler="0 0 22.918"/>
          <body name="ball" mocap="true"><geom name="ball" size="0.01"/></body>
        </worldbody></mujoco>"""
    )
    data = mujoco.MjData(model)
    extent = (0.10, 0.16, 0.24) if kind == "box" else (0.10, 0.10, 0.24)
    base = np.array([0.3, 0.1, 0.8])
    thing = StandingObject("thing", extent, base, math.radians(22.918), round=kind == "cylinder")
    rng = np.random.default_rng(4)
    compared = 0
    for offset in rng.uniform(-0.25, 0.25, (60, 3)):
        at = base + np.array([0, 0, 0.12]) + offset
        depth = thing.depth_m(at[None], np.array([0.01]))
        data.mocap_pos[0] = at
        mujoco.mj_forward(model, data)
        theirs = mujoco.mj_geomDistance(model, data, 0, 1, 1.0, None)
        if theirs > 0.001:  # how deep something is inside, MuJoCo only estimates
            assert -depth == pytest.approx(theirs, abs=1e-4)
            compared += 1
        else:
            assert depth > -0.0012
    assert compared > 30


def test_out_of_a_box_leads_the_nearest_face():
    box = Slab(np.array([0.0, 0.0, 0.0]), np.array([1.0, 1.0, 0.1]))
    at = np.array([[0.5, 0.5, 0.09], [0.5, 0.5, 0.01], [0.01, 0.5, 0.05], [0.5, 0.5, 0.12]])
    depth, out = box.push(at, np.full(4, 0.03))
    np.testing.assert_allclose(depth, [0.04, 0.04, 0.04, 0.01], atol=1e-12)
    np.testing.assert_allclose(out, [[0, 0, 1], [0, 0, -1], [-1, 0, 0], [0, 0, 1]], atol=1e-12)


def drawn_vertices(world, name):
    """World vertices of a drawn geom, as MuJoCo places its mesh."""
    model, data = world.model, world.data
    geom = model.geom(name).id
    mesh = model.geom_dataid[geom]
    first = model.mesh_vertadr[mesh]
    local = model.mesh_vert[first : first + model.mesh_vertnum[mesh]]
    return local @ data.geom_xmat[geom].reshape(3, 3).T + data.geom_xpos[geom]


@pytest.mark.sample(1)
@pytest.mark.parametrize("stature", [1.55, 1.72, 1.9])
def test_bars_lie_in_what_is_drawn(stature):
    person = Anatomy.of(stature)
    world = build(SceneSpec(anatomy=person))
    played = replace(
        perform(load_scenario("cross"), 100, {"frames": 3}).script,
        scene=SceneSpec(anatomy=person),
    )
    world.place(played.pose(0.0))
    body = played.body(0.0)
    for side, name in enumerate(SIDES):
        shape = arm_shape(person, side, body.curls[side])
        bars = shape.bars(body.arms[side])
        for part, geom in ((FOREARM, f"forearm:{name}"), (HAND, f"{SKIN}palm:{name}")):
            drawn = drawn_vertices(world, geom)
            along = (drawn - body.arms[side].palm_m) @ body.arms[side].hand[:, 0]
            if part == HAND:  # the wrist's stump is in the sleeve
                drawn = drawn[along > -0.8 * person.wrist_to_palm_m]
            chosen = part == PART_OF_BAR
            own = Capsules(bars.starts_m[chosen], bars.ends_m[chosen], bars.radii_m[chosen])
            inside = depth_of(drawn, 0.0, own)
            # The drawn surface is that of the bars; the poles of end caps are deeper in.
            assert inside.min() > -0.0045
            assert abs(np.median(inside)) < 0.0025
        # The points against solids have the same surface: each lies in the bars.
        cloud = shape.points(body.arms[side])
        assert depth_of(cloud, 0.0, bars)[PART_OF_POINT <= FOREARM].min() > 0.0


@pytest.mark.parametrize("stature", [1.55, 1.72, 1.9])
def test_solids_follow_the_drawn_torso_and_head(stature):
    person = Anatomy.of(stature)
    solids = person_solids(person, TORSO, np.eye(3), HEAD, np.eye(3))
    drawn = torso_surface(person).vertices_m
    drawn = drawn[drawn[:, 2] > -0.29 * stature] + TORSO
    depth = solids.push(drawn, np.zeros(len(drawn)))[0][1:5].max(axis=0)
    # The slope from shoulder to neck is plainer than what is drawn.
    assert np.abs(np.quantile(depth, [0.1, 0.25, 0.5, 0.75, 0.9])).max() < 0.008
    assert np.abs(depth).max() < 0.035
    head = head_surface(person).vertices_m + HEAD
    depth = solids.push(head, np.zeros(len(head)))[0][0]
    assert np.abs(np.quantile(depth, [0.05, 0.25, 0.5, 0.75])).max() < 0.006
    assert depth.min() > -0.018  # the nose


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


def test_a_hand_that_closes_changes_its_shape_without_steps():
    ends = [
        hand_capsules(PERSON, 0, np.full(5, curl)).ends_m for curl in np.linspace(0.2, 0.201, 21)
    ]
    steps = np.linalg.norm(np.diff(ends, axis=0), axis=2)
    assert 1e-6 < steps.max() < 3e-5  # 1/20 000 of a fist that bends 4.3 rad


def test_a_hand_laid_at_its_height_touches_the_table():
    rotation = hand_rotation(0, 0.3, 0.12, 0.1)
    height = height_above_table(PERSON, 0, rotation, CURLS[0])
    bars = hand_capsules(PERSON, 0, CURLS[0]).placed(np.array([0.4, -0.2, 0.73 + height]), rotation)
    ends = np.concatenate([bars.starts_m, bars.ends_m])
    depth, _ = TABLE.slab().push(ends, np.tile(bars.radii_m, 2))
    assert depth.max() == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize(("height", "above"), [(0.72, True), (0.74, True), (0.69, False)])
def test_a_hand_in_the_table_leaves_it_on_its_own_side(height, above):
    palms = (np.array([0.4, -0.2, height]), REST[1])
    arms = separate(PERSON, palms, solver(), CURLS, ALL)
    left = penetration(PERSON, arms, CURLS, ALL)
    assert left.pairs["right hand", "table"] <= DEEPEST_M
    assert (arms[0].palm_m[2] > 0.73) == above
    assert abs(arms[0].palm_m[2] - height) < 0.08  # moved out, not thrown
    assert norm(arms[1].palm_m - REST[1]) < 1e-9


def test_a_hand_at_the_near_edge_is_pushed_towards_the_person():
    hand = hand_rotation(0, 0.0, math.pi / 2, 0.0)  # fingers down, before the edge

    def solve(side, palm, swivel_rad):
        turn = hand if side == 0 else hand_rotation(1, 0.3, 0.0, 0.0)
        return solve_arm(PERSON, side, JOINTS[side], palm, turn, swivel_rad or 0.3)

    palm = np.array([0.152, -0.3, 0.716])
    room = Obstacles(TABLE, person_solids(PERSON, TORSO - [0.3, 0, 0], np.eye(3), HEAD, np.eye(3)))
    arms = separate(PERSON, (palm, REST[1]), solve, CURLS, room)
    assert penetration(PERSON, arms, CURLS, room).pairs["right hand", "table"] <= DEEPEST_M
    moved = arms[0].palm_m - palm
    assert moved[0] < -0.004
    assert norm(moved) < 0.03


@pytest.mark.parametrize("gap_m", [0.0, 0.01, 0.03, 0.06])
def test_hands_in_each_other_are_taken_apart_both_alike(gap_m):
    palms = (np.array([0.35, -gap_m / 2, 0.95]), np.array([0.35, gap_m / 2, 0.95]))
    arms = separate(PERSON, palms, solver(yaw=0.1, roll=1.4), CURLS, ALL)
    assert penetration(PERSON, arms, CURLS, ALL).worst_m <= DEEPEST_M
    assert arms[0].palm_m[1] < arms[1].palm_m[1]
    assert abs(arms[0].palm_m[1] + arms[1].palm_m[1]) < 0.02


def test_a_hand_in_the_face_is_put_before_it():
    palms = (np.array([0.06, 0.0, 1.22]), np.array([0.4, 0.2, 0.8]))
    arms = separate(PERSON, palms, solver(yaw=1.2, pitch=-0.4, roll=1.3), CURLS, ALL)
    assert penetration(PERSON, arms, CURLS, ALL).pairs["right hand", "head"] <= DEEPEST_M
    assert arms[0].palm_m[0] > 0.06


def test_arms_that_are_clear_are_left_where_they_are():
    palms = (np.array([0.35, -0.2, 0.9]), np.array([0.35, 0.2, 0.9]))
    arms = separate(PERSON, palms, solver(), CURLS, ALL)
    np.testing.assert_array_equal([a.palm_m for a in arms], list(palms))


@pytest.mark.parametrize("rise_m", [0.01, 0.03, 0.05])
@pytest.mark.parametrize("past_m", [0.06, 0.12, 0.18])
def test_crossed_arms_keep_their_sleeves_out_of_each_other(rise_m, past_m):
    palms = (np.array([0.34, past_m, 0.95]), np.array([0.34, -past_m, 0.95 + rise_m]))
    solve = solver(yaw=0.9, pitch=-0.2, roll=0.6)
    crossed = (solve(0, palms[0], None), solve(1, palms[1], None))
    before = penetration(PERSON, crossed, CURLS, ALL)
    assert before.worst_m > 0.02  # what the projection has to undo
    arms = separate(PERSON, palms, solve, CURLS, ALL)
    assert penetration(PERSON, arms, CURLS, ALL).worst_m <= DEEPEST_M
    assert arms[1].palm_m[2] > arms[0].palm_m[2]  # the upper one stays the upper one
    for arm, palm in zip(arms, palms, strict=True):
        assert norm(arm.palm_m - palm) < 0.08


@pytest.mark.long
@pytest.mark.parametrize("seed", [100, 101, 104])
def test_contact_changes_smoothly_while_arms_cross(seed):
    """Steps of 1/100 s: what the contact adds changes by less than a few mm."""
    played = perform(load_scenario("cross"), seed)
    cue = next(c for c in played.script.plan.cues if c.name == "cross")
    times = np.arange(cue.from_s - 0.2, cue.to_s + 0.4, 0.01).tolist()
    path = np.array([[arm.palm_m for arm in played.script.body(t).arms] for t in times])
    told = np.array([[h.at(t).position_m for h in played.script.plan.hands] for t in times])
    added = np.diff(path - told, axis=0)
    assert np.linalg.norm(added, axis=2).max() < 0.006


@pytest.mark.sample(1)
@pytest.mark.parametrize("height", [0.87, 0.89, 0.91, 0.93])
def test_a_hand_passing_over_the_other_one_is_lifted_without_a_jump(height):
    added, room = [], Obstacles(LOW_TABLE, ALL.solids)
    for y in np.linspace(0.15, -0.30, 91):
        palms = (np.array([0.42, -0.12, 0.84]), np.array([0.36, y, height]))
        arms = separate(PERSON, palms, solver(yaw=0.5), CURLS, room)
        assert penetration(PERSON, arms, CURLS, room).worst_m <= DEEPEST_M
        added.append(np.concatenate([a.palm_m - p for a, p in zip(arms, palms, strict=True)]))
    assert np.abs(added).max() > 0.002
    assert np.abs(np.diff(added, axis=0)).max() < 0.005  # a step of 5 mm on the way


def test_natural_neighbours_do_not_count():
    """Elbows at the sides, a hand folded to its own shoulder: nothing to part."""
    low = solver(swivel=0.0)
    palms = (np.array([0.30, -0.19, 0.80]), np.array([0.30, 0.19, 0.80]))
    arms = separate(PERSON, palms, low, CURLS, ALL)
    for side in (0, 1):
        assert norm(arms[side].palm_m - palms[side]) < 0.002


def test_what_cannot_be_parted_is_as_good_as_it_gets_and_told():
    low = Table(top_m=1.6, near_x_m=-1.0, far_x_m=2.0, half_width_m=2.0, thickness_m=1.5)
    walls = Obstacles(low, ALL.solids)
    arms = separate(PERSON, REST, solver(), CURLS, walls)
    left = penetration(PERSON, arms, CURLS, walls)
    assert left.worst_m > 0.1
    assert left.worst[1] == "table"


def test_overlap_is_told_by_the_pair_of_parts():
    palms = (np.array([0.30, 0.05, 0.95]), np.array([0.30, 0.02, 0.95]))
    solve = solver()
    arms = (solve(0, palms[0], None), solve(1, palms[1], None))
    found = penetration(PERSON, arms, CURLS, ALL)
    bars = [arm_shape(PERSON, s, CURLS[s]).bars(arms[s]) for s in (0, 1)]
    overlap = overlaps(bars[0], bars[1])[0]
    hands = overlap[np.ix_(PART_OF_BAR == HAND, PART_OF_BAR == HAND)]
    assert found.hands_m == pytest.approx(hands.max())
    assert ("right upper arm", "left upper arm") not in found.pairs
    assert ("right upper arm", "torso") not in found.pairs
    assert found.worst_m == max(found.pairs.values())
