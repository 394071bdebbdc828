"""A picture of which only a window is drawn must be that of which all is drawn."""

from dataclasses import replace

import numpy as np
import pytest

from sim.camera.render import StereoRenderer
from sim.motion.motion import object_at_rest
from sim.person.rest import rest_pose
from sim.pose import Transform
from sim.scene.world import build
from sim.specs import ObjectSpec, RigSpec, RoomSpec, SceneSpec

CAN = ObjectSpec("can", "can", (0.066, 0.066, 0.115), (0.72, 0.08, 0.10), (0.5, -0.3))
SCREEN = ObjectSpec("screen", "box", (0.02, 0.3, 0.4), (0.3, 0.3, 0.3), (0.9, 0.3), base_m=1.7)
RIG = RigSpec(tilt_rad=0.28, focal_px=270.0, width_px=320, height_px=240)
SCENE = SceneSpec(rig=RIG, room=RoomSpec(objects=(CAN, SCREEN)))
LENS = replace(SCENE, rig=replace(RIG, distortion=(-0.2, 0.05, 0.001, 0.0, 0.0)))
AWAY = Transform(np.array([0.0, 0.0, -4.0]), np.eye(3))
HOME = {name: object_at_rest(SCENE.room, name) for name in ("can", "screen")}
PALMS_M = (((0.35, -0.3, 1.1), (0.45, 0.1, 0.85)), ((0.30, -0.2, 0.9), (0.20, 0.25, 1.15)))


def pose(palms=0, **places):
    """A pose of the person, with the objects at home or elsewhere."""
    person = rest_pose(SCENE.anatomy, palms_m=PALMS_M[palms])
    return replace(person, objects={**HOME, **places})


def at(x, y, z):
    return Transform(np.array([x, y, z]), np.eye(3))


# What differs from the still scene, in which the can is on the table and the screen above it.
POSES = {
    "only the person": pose(),
    "can moved": pose(can=at(0.45, 0.3, 0.95)),
    "can gone": pose(can=AWAY),
    "shadow moved": pose(screen=at(0.9, -0.3, 1.7)),
    "through the camera": pose(screen=at(1.4, 0.0, 1.2)),
}


def opened(scene, still=True):
    return StereoRenderer(build(scene), pose() if still else None)


def rendered(renderer, name, **options):
    renderer.world.place(POSES[name])
    return renderer.render(**options)


@pytest.mark.sample(1)
@pytest.mark.parametrize("lens", [False, True])
def test_the_picture_is_that_of_which_all_is_drawn(lens):
    scene, names = (LENS, ["can moved"]) if lens else (SCENE, list(POSES))
    with opened(scene, still=False) as plain, opened(scene) as still:
        for name in names:
            check_same(rendered(plain, name), rendered(still, name))
        empty = (rendered(renderer, "can gone", person=False) for renderer in (plain, still))
        check_same(*empty)


def check_same(whole, drawn_in_part):
    for full, part in zip(whole, drawn_in_part, strict=True):
        steps = np.abs(full.colour.astype(int) - part.colour).max(axis=-1)
        # The projection of a window is rounded otherwise: a few samples lie on an edge.
        assert (steps > 2).mean() < 2e-4
        assert (full.geoms != part.geoms).mean() < 1e-4
        assert (full.targets != part.targets).sum() <= 2
        assert np.quantile(np.abs(full.depth_m - part.depth_m), 0.999) < 2e-5
        assert (full.amodal != part.amodal).sum() <= 2


def digest(views):
    parts = [(v.colour, v.depth_m, v.geoms, v.targets, v.amodal) for v in views]
    return [part.tobytes() for view in parts for part in view]


@pytest.mark.long
def test_a_picture_depends_on_no_picture_before_it():
    with opened(SCENE) as one, opened(SCENE) as other:
        first = digest(rendered(one, "only the person"))
        rendered(other, "shadow moved", labels=False, amodal=False)
        rendered(other, "can gone", colour=False, person=False)
        assert digest(rendered(other, "only the person")) == first


def test_objects_that_the_still_pose_does_not_name_are_where_they_were_at_first():
    with opened(SCENE) as named:
        world = build(SCENE)
        with StereoRenderer(world, rest_pose(SCENE.anatomy)) as unnamed:
            world.place(POSES["can gone"])
            views = rendered(named, "can gone", amodal=False)
            assert (unnamed.view(0, amodal=False).colour == views[0].colour).all()
