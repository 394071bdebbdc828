"""Keypoints against the posed model: MuJoCo's frames and meshes, and rays for what hides them."""

from dataclasses import replace

import numpy as np
import pytest
from any_pose import any_pose

from pjpdaf.camera import distort_points, project, to_camera
from sim.anatomy import Anatomy
from sim.camera.rays import cast
from sim.camera.render import StereoRenderer
from sim.dataset.labels.instances import instances_of
from sim.dataset.labels.keypoints import Keypoints
from sim.dataset.labels.records import KEYPOINTS, NOT_LABELLED, OCCLUDED, VISIBLE
from sim.dataset.labels.visibility import MARGIN
from sim.person.geoms import SKIN
from sim.person.hand import FINGERS, fingers
from sim.person.rest import rest_pose
from sim.pose import SIDES, Transform
from sim.randomness import generator
from sim.scene.world import build
from sim.specs import Appearance, RigSpec, SceneSpec

ANATOMY = Anatomy.of(1.81, hand_scale=1.06, head_scale=0.96)
SCENE = SceneSpec(
    anatomy=ANATOMY,
    appearance=Appearance(sleeves="short", hair="bald"),
    rig=RigSpec(tilt_rad=0.28, vergence_rad=0.05, distortion=(-0.2, 0.05, 0.001, -0.0008)),
)
SEEDS = range(100, 130)
OFTEN = 10  # poses of a seed


@pytest.fixture(scope="module")
def world():
    return build(SCENE)


@pytest.fixture(scope="module")
def renderer(world):
    with StereoRenderer(world) as opened:
        yield opened


def vertices(world, name):
    """Vertices (n, 3) of a mesh geom as it is drawn, world [m]."""
    model, geom = world.model, world.model.geom(name).id
    mesh = model.geom_dataid[geom]
    first, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
    own = model.mesh_vert[first : first + count].astype(float)
    return own @ world.data.geom_xmat[geom].reshape(3, 3).T + world.data.geom_xpos[geom]


def test_keypoints_are_where_the_model_is_posed(world, seed):
    points = Keypoints(ANATOMY)
    rng = generator(seed, "keypoints")
    for _ in range(OFTEN):
        pose = any_pose(ANATOMY, rng)
        world.place(pose)
        at = dict(zip(KEYPOINTS, points.positions(pose), strict=True))
        np.testing.assert_allclose(at[0, "head_centre"], pose.head.position_m, atol=1e-12)
        face = np.linalg.norm(vertices(world, f"{SKIN}face") - at[0, "chin"], axis=1)
        assert face.min() < 1e-6
        for target, side in enumerate(SIDES, start=1):
            body = world.data.body(f"hand:{side}")
            wrist = body.xpos + body.xmat.reshape(3, 3) @ [-ANATOMY.wrist_to_palm_m, 0, 0]
            np.testing.assert_allclose(at[target, "palm_centre"], body.xpos, atol=1e-9)
            np.testing.assert_allclose(at[target, "wrist"], wrist, atol=1e-9)
            for finger in fingers(ANATOMY):
                tip = at[target, f"{finger.name}_tip"]
                last = world.data.body(f"{finger.name}2:{side}")
                end = last.xpos + last.xmat.reshape(3, 3)[:, 0] * finger.lengths_m[2]
                np.testing.assert_allclose(tip, end, atol=1e-9)
                # The drawn finger's round end is about it.
                drawn = vertices(world, f"{SKIN}{finger.name}2:{side}")
                ahead = (drawn - tip) @ last.xmat.reshape(3, 3)[:, 0]
                assert ahead.max() == pytest.approx(finger.radii_m[-1], abs=1e-6)
                round_end = np.linalg.norm(drawn[ahead > 1e-6] - tip, axis=1)
                np.testing.assert_allclose(round_end, finger.radii_m[-1], atol=1e-6)


@pytest.mark.parametrize("scale", [0.9, 1.0, 1.12])
def test_the_chin_is_the_foremost_point_between_lip_and_throat(scale):
    anatomy = Anatomy.of(head_scale=scale)
    centre, chin = Keypoints(anatomy).positions(rest_pose(anatomy))[:2]
    forward, left, up = (chin - centre) / np.array([0.0989, 0.0761, 0.1127]) / scale
    assert 0.6 < forward < 0.8
    assert abs(left) < 1e-9
    assert -0.75 < up < -0.65


def expected(world, pose, k, geom, gap_m, along):
    """Status of keypoint k by what a ray to it met, gap_m before it; None where it could be either.

    along (3,): the ray's direction, world.
    """
    target, name = KEYPOINTS[k]
    if geom < 0 or world.targets[geom] != target:
        return OCCLUDED
    met = world.model.geom(geom).name.removeprefix(SKIN)
    if target == 0:
        sure, never = {"head_centre": (0.12, np.inf), "chin": (0.005, 0.02)}[name]
        return VISIBLE if gap_m < sure else OCCLUDED if gap_m > never else None
    if name.endswith("_tip"):
        finger = FINGERS.index(name.removesuffix("_tip"))
        last = world.data.body(f"{FINGERS[finger]}2:{SIDES[target - 1]}")
        if met.startswith(f"{FINGERS[finger]}2"):  # from the side or from ahead
            return VISIBLE if last.xmat.reshape(3, 3)[:, 0] @ along < 0.5 else None
        far = gap_m > 3 * fingers(ANATOMY)[finger].radii_m[-1]
        return OCCLUDED if far and not met.startswith(FINGERS[finger]) else None
    if met.startswith("palm") and gap_m < 0.025:
        return VISIBLE
    return OCCLUDED if gap_m > 0.07 else None


def test_visible_is_what_rays_meet_first(world, renderer, seed):
    """A ray to a keypoint meets the keypoint's own part of the body, or it is occluded."""
    points, instances = Keypoints(ANATOMY), instances_of(world)
    rng = generator(seed, "visible")
    said = []
    for _ in range(OFTEN):
        pose = any_pose(ANATOMY, rng)
        world.place(pose)
        places = points.positions(pose)
        for index, camera in enumerate(world.rig.cameras):
            view = renderer.view(index, colour=False, amodal=False)
            ids = instances.ids(view.geoms)
            pixels, status = points.project(pose, camera, world.lenses[index], ids, view.depth_m)
            met, met_m = cast(world, camera, pixels)
            along = places - camera.centre_w
            range_m = np.linalg.norm(along, axis=1)
            gap_m = range_m * (1 - met_m / to_camera(camera, places)[:, 2])
            for k in np.flatnonzero(status != NOT_LABELLED):
                way = along[k] / range_m[k]
                said.append((status[k], expected(world, pose, k, met[k], gap_m[k], way)))
                if status[k] == VISIBLE:
                    x, y = np.rint(pixels[k]).astype(int)
                    assert view.targets[y, x] == KEYPOINTS[k][0]
    sure = [(one, other) for one, other in said if other is not None]
    assert len(sure) > 0.6 * len(said)
    assert min(sum(other == s for _, other in sure) for s in (OCCLUDED, VISIBLE)) > 0.1 * len(said)
    wrong = sum(one != other for one, other in sure) / len(sure)
    print("keypoints that differ from rays:", wrong)
    assert wrong < 0.02


def placed(world, renderer, pose, view=0):
    """Name -> (pixel, status) of the right hand's keypoints in a view of this pose."""
    world.place(pose)
    drawn = renderer.view(view, colour=False, amodal=False)
    camera, lens = world.rig.cameras[view], world.lenses[view]
    ids = instances_of(world).ids(drawn.geoms)
    pixels, status = Keypoints(ANATOMY).project(pose, camera, lens, ids, drawn.depth_m)
    found = zip(KEYPOINTS, pixels, status, strict=True)
    return {name: (pixel, s) for (target, name), pixel, s in found if target == 1}


def held(x, z, centre=(0.45, -0.1, 1.15), curl=0.06):
    """The right hand alone, its fingers along x, the back of the hand along z."""
    pose = rest_pose(ANATOMY, curl=curl)
    rotation = np.column_stack([x, np.cross(z, x), z])
    return replace(pose, hands=(Transform(np.array(centre), rotation), pose.hands[1]))


@pytest.mark.sample(2)
@pytest.mark.parametrize(
    ("x", "z"),
    [
        ((0, 0, 1), (1, 0, 0)),
        ((0, 0, 1), (-1, 0, 0)),
        ((0, 0, 1), (0, -1, 0)),
        ((0, 1, 0), (1, 0, 0)),
    ],
    ids=["back", "palm", "edge", "level"],
)
def test_an_open_hand_shows_wrist_palm_and_tips(world, renderer, x, z):
    seen = placed(world, renderer, held(np.array(x, float), np.array(z, float)))
    assert seen["palm_centre"][1] == VISIBLE
    assert seen["wrist"][1] == VISIBLE
    tips = [seen[f"{finger}_tip"][1] for finger in FINGERS[1:]]
    # On edge, one finger lies behind the other.
    assert tips.count(VISIBLE) == 4 or (z[1] and tips[-1] == VISIBLE)


def test_a_fist_hides_its_tips_from_behind_and_its_palm_from_before(world, renderer):
    up = np.array([0.0, 0.0, 1.0])
    back = placed(world, renderer, held(up, np.array([1.0, 0, 0]), curl=1.0))
    assert back["palm_centre"][1] == VISIBLE
    assert [back[f"{finger}_tip"][1] for finger in FINGERS[1:]] == [OCCLUDED] * 4
    front = placed(world, renderer, held(up, np.array([-1.0, 0, 0]), curl=1.0))
    assert front["palm_centre"][1] == OCCLUDED


def test_the_table_hides_a_hand_below_it(world, renderer):
    below = held(np.array([1.0, 0, 0]), np.array([0, 0, 1.0]), centre=(0.26, -0.2, 0.68))
    assert {status for _, status in placed(world, renderer, below).values()} == {OCCLUDED}


def test_outside_the_picture_and_behind_the_camera_there_is_no_label(world, renderer):
    x, z = np.array([1.0, 0, 0]), np.array([0, 0, 1.0])
    aside = placed(world, renderer, held(x, z, centre=(0.4, -1.6, 1.0)))
    assert {status for _, status in aside.values()} == {NOT_LABELLED}
    behind = placed(world, renderer, held(x, z, centre=(1.9, -0.1, 1.2)))
    assert {status for _, status in behind.values()} == {NOT_LABELLED}
    assert all(np.isnan(pixel).all() for pixel, _ in behind.values())


def test_pixels_are_of_the_real_picture(world, renderer):
    camera = world.rig.left
    pose = rest_pose(ANATOMY)
    found = placed(world, renderer, pose)
    places = Keypoints(ANATOMY).positions(pose)[2:9]
    expected = distort_points(camera, project(camera, places))
    np.testing.assert_allclose([pixel for pixel, _ in found.values()], expected, atol=1e-3)
    assert np.abs(expected - project(camera, places)).max() > 2


def test_the_margin_is_between_a_parts_own_surface_and_the_next_part():
    """Of tips: less than what a finger of the same hand before it takes, two radii and its own."""
    for finger in fingers(ANATOMY):
        assert finger.radii_m[-1] < MARGIN * finger.radii_m[-1] < 3 * finger.radii_m[-1]
