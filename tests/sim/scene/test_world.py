from dataclasses import replace

import cv2
import numpy as np
import pytest

from pjpdaf.camera import project
from pjpdaf.targets import HEAD, LEFT_HAND, RIGHT_HAND, TARGETS
from sim.anatomy import Anatomy
from sim.camera.render import StereoRenderer
from sim.labels import centres
from sim.person.geoms import SKIN
from sim.person.rest import rest_pose
from sim.pose import Transform
from sim.scene.objects import KINDS
from sim.scene.world import build
from sim.specs import Appearance, ObjectSpec, RigSpec, RoomSpec, SceneSpec

RIG = RigSpec(tilt_rad=0.28)
THINGS = tuple(
    ObjectSpec(kind, kind, (0.09, 0.09, 0.10), (0.1, 0.4, 0.5), (0.55, 0.2 * i - 0.4))
    for i, kind in enumerate(KINDS)
)
SCENE = SceneSpec(rig=RIG, room=RoomSpec(objects=THINGS))


@pytest.fixture(scope="module")
def world():
    return build(SCENE)


@pytest.fixture(scope="module")
def views(world):
    world.place(rest_pose(SCENE.anatomy))
    with StereoRenderer(world) as renderer:
        yield renderer.render()


def test_every_target_has_skin_and_nothing_else_has(world):
    for geom, target in enumerate(world.targets):
        assert (target >= 0) == world.model.geom(geom).name.startswith(SKIN)
    assert set(world.targets.tolist()) == {-1, HEAD, RIGHT_HAND, LEFT_HAND}


def test_the_left_hand_is_on_the_right_of_the_picture(views):
    for view in views:
        right, left = (np.nonzero(view.targets == t)[1].mean() for t in (RIGHT_HAND, LEFT_HAND))
        assert left > right + 50


def test_skin_lies_around_the_projected_centres(world, views):
    at = centres(rest_pose(SCENE.anatomy))
    for view, camera in zip(views, world.rig.cameras, strict=True):
        for target in range(len(TARGETS)):
            ys, xs = np.nonzero(view.targets == target)
            offset = [xs.mean(), ys.mean()] - project(camera, at[target])
            assert np.linalg.norm(offset) < 30
            assert len(xs) > 1000


def test_skin_has_the_documented_colour_and_does_not_clip(views):
    """H 8-31 degrees, S .36-.52, V > .2: where a detector looks for skin."""
    for view in views:
        hsv = cv2.cvtColor(view.colour.astype(np.float32) / 255, cv2.COLOR_BGR2HSV)
        for target in range(len(TARGETS)):
            inside = cv2.erode((view.targets == target).astype(np.uint8), np.ones((3, 3))) > 0
            h, s, v = hsv[inside].T
            skin = (h > 8) & (h < 31) & (s > 0.36) & (s < 0.53) & (v > 0.2)
            # Eyes, brows and nostrils are painted on the face.
            assert skin.mean() > (0.90 if target == HEAD else 0.995)
        assert (view.colour[view.targets >= 0] == 255).mean() < 0.001
        assert view.colour[view.targets >= 0].max(initial=0) <= 255


def test_free_head_and_hands_are_wholly_visible(views):
    for view in views:
        for target in range(len(TARGETS)):
            visible = (view.targets == target).sum()
            assert visible > 0.93 * view.amodal_px[target]


def test_hiding_the_person_hides_all_skin_and_leaves_the_room(world, views):
    world.place(rest_pose(SCENE.anatomy))
    with StereoRenderer(world) as renderer:
        empty = renderer.render(amodal=False, person=False)
    names = {world.model.geom(g).name for g in np.unique(empty[0].geoms)}
    assert not any(name.startswith((SKIN, "torso", "hair", "cuff")) for name in names)
    assert {"table:top", "wall:back", "object:can", "object:cup", "object:ball"} <= names
    for view, full in zip(empty, views, strict=True):
        assert (view.targets == -1).all()
        body = np.isin(full.geoms, np.flatnonzero(np.isin(world.model.geom_group, range(1, 5))))
        # Away from the person and the person's shadow nothing changes.
        same = (view.colour == full.colour).all(axis=-1)
        assert same[:60, :100].all()
        assert not same[body].all()


def test_a_box_in_front_hides_a_hand():
    screen = ObjectSpec("screen", "box", (0.02, 0.30, 0.30), (0.2, 0.2, 0.2), (0.60, -0.20))
    scene = replace(SCENE, room=RoomSpec(objects=(screen,)))
    world = build(scene)
    world.place(rest_pose(scene.anatomy))
    with StereoRenderer(world) as renderer:
        for view in renderer.render(colour=False):
            visible = [(view.targets == t).sum() for t in range(len(TARGETS))]
            assert visible[RIGHT_HAND] < 0.1 * view.amodal_px[RIGHT_HAND]
            assert visible[LEFT_HAND] > 0.9 * view.amodal_px[LEFT_HAND]
            assert view.amodal_px[RIGHT_HAND] > 1000


def test_a_fist_is_shorter_than_a_flat_hand(world):
    pose = rest_pose(SCENE.anatomy, palms_m=((0.35, -0.2, 1.0), (0.35, 0.2, 1.0)))
    curls = np.zeros((2, 5))
    curls[0] = 1.0
    world.place(replace(pose, curls=curls))
    tips = {
        side: world.data.body(f"middle2:{side}").xpos - pose.hands[i].position_m
        for i, side in enumerate(("right", "left"))
    }
    assert tips["right"] @ pose.hands[0].rotation[:, 0] < 0.05
    assert tips["right"] @ pose.hands[0].rotation[:, 2] < -0.01  # into the palm
    assert tips["left"] @ pose.hands[1].rotation[:, 0] > 0.07


def test_the_hands_are_mirror_images(world):
    world.place(rest_pose(SCENE.anatomy, curl=0.5))
    for name in ("thumb2", "index2", "little2"):
        right, left = (world.data.body(f"{name}:{side}").xpos for side in ("right", "left"))
        np.testing.assert_allclose(right * [1, -1, 1], left, atol=1e-9)
    # Thumbs point inwards.
    thumb, little = world.data.body("thumb2:right").xpos, world.data.body("little2:right").xpos
    assert thumb[1] > little[1]


def test_objects_follow_the_pose(world):
    pose = rest_pose(SCENE.anatomy)
    up = Transform(np.array([0.4, 0.0, 1.1]), np.eye(3))
    world.place(replace(pose, objects={"can": up}))
    np.testing.assert_allclose(world.data.body("object:can").xpos, up.position_m)
    with pytest.raises(KeyError, match=r"moves 'object:hat', the scene has the objects .*'ball'"):
        world.place(replace(pose, objects={"hat": up}))


def test_an_unknown_kind_of_object_is_refused():
    hat = ObjectSpec("hat", "hat", (0.1, 0.1, 0.1), (0, 0, 0), (0.5, 0))
    with pytest.raises(ValueError, match=r"'hat': kind must be one of .*can.*, got 'hat'"):
        build(SceneSpec(room=RoomSpec(objects=(hat,))))


@pytest.mark.parametrize("stature_m", [1.52, 1.90])
def test_the_body_scales(stature_m):
    anatomy = Anatomy.of(stature_m)
    look = Appearance(sleeves="short", beard=True, glasses=True)
    world = build(SceneSpec(anatomy=anatomy, appearance=look, rig=RIG))
    world.place(rest_pose(anatomy))
    with StereoRenderer(world) as renderer:
        for view in renderer.render(colour=False):
            for target in range(len(TARGETS)):
                visible = (view.targets == target).sum()
                assert visible > 0.85 * view.amodal_px[target] > 800


def test_the_texture_seed_changes_the_room_alone():
    pictures = []
    for seed in (0, 1):
        scene = replace(SCENE, room=replace(SCENE.room, texture_seed=seed))
        world = build(scene)
        world.place(rest_pose(scene.anatomy))
        with StereoRenderer(world) as renderer:
            pictures.append(renderer.render(amodal=False)[0])
    assert (pictures[0].geoms == pictures[1].geoms).mean() > 0.99  # books have other sizes
    assert (pictures[0].colour != pictures[1].colour).any(axis=-1).mean() > 0.3
