"""Rooms of every word: they can be drawn, and nothing but the person is a target."""

from dataclasses import fields, replace

import numpy as np
import pytest
from plain_surroundings import PLAIN

from sim.camera.render import StereoRenderer
from sim.dataset.labels.instances import FIRST_OBJECT, ROOM, TABLE, instances_of
from sim.person.geoms import SKIN
from sim.person.rest import rest_pose
from sim.scene.world import build
from sim.specs import RigSpec, RoomSpec, SceneSpec, Surroundings
from sim.surroundings import words
from sim.surroundings.clutter import bystander_of

RIG = RigSpec(focal_px=240.0, width_px=320, height_px=240, tilt_rad=0.2, distance_m=1.5)
CHOICES = {
    "wall": words.WALLS,
    "floor": words.FLOORS,
    "door": words.DOORS[1:],
    "window": words.WINDOWS[1:],
    "shelves": words.SHELVES[1:],
    "screen": words.SCREENS,
    "chair": words.CHAIRS,
    "table_shape": words.TABLE_SHAPES,
    "table_legs": words.TABLE_LEGS,
    "bystander": words.BYSTANDERS,
    "lamp": words.LAMPS,
}


def full(number):
    """Surroundings with much in them: over numbers 0 to 3 every word is taken."""
    chosen = {name: options[number % len(options)] for name, options in CHOICES.items()}
    return replace(
        PLAIN, arrangement=number, half_width_m=2.5, pictures=2, poster=True, plants=1,
        floor_clutter=2, **chosen,
    )  # fmt: skip


def scene_with(surroundings, **room):
    second = bystander_of(surroundings)
    objects = (second,) if second else ()
    room = RoomSpec(surroundings=surroundings, objects=objects, **room)
    return SceneSpec(rig=RIG, room=room)


@pytest.mark.sample(1)
@pytest.mark.parametrize("number", range(4))
def test_a_room_is_drawn_with_all_that_its_words_say(number):
    surroundings = full(number)
    scene = scene_with(surroundings)
    world = build(scene)
    names = [world.model.geom(geom).name for geom in range(world.model.ngeom)]
    for start in ("wall:back", "floor", "ceiling", "door:", "window:", "poster", "table:top"):
        assert any(name.startswith(start) for name in names), start
    kind = "board" if surroundings.shelves == "board" else surroundings.shelves
    assert any(name.startswith(f"{kind}:") for name in names)
    world.place(rest_pose(scene.anatomy, scene.room))
    instances = instances_of(world)
    with StereoRenderer(world) as renderer:
        views = renderer.render(amodal=False)
    for view in views:
        ids = instances.ids(view.geoms)
        assert {ROOM, TABLE} <= set(np.unique(ids).tolist())
        assert (view.geoms >= 0).all(), "nothing is seen past the walls"
        for target in range(3):
            assert (view.targets == target).sum() > 150
        level = view.colour.mean()
        assert 25 < level < 215
    for geom in np.flatnonzero(world.targets >= 0):
        assert names[geom].startswith(SKIN)
    assert not any(name.startswith(SKIN) and "second_person" in name for name in names)


def test_the_second_person_is_an_instance_of_its_own():
    surroundings = replace(PLAIN, bystander="still", depth_m=2.4)
    scene = scene_with(surroundings)
    world = build(scene)
    world.place(rest_pose(scene.anatomy, scene.room))
    table = instances_of(world)
    assert [(i.id, i.name) for i in table.table if i.kind == "object"] == [
        (FIRST_OBJECT, "second_person")
    ]
    with StereoRenderer(world) as renderer:
        view = renderer.view(0, colour=False, amodal=False)
    mine = table.ids(view.geoms) == FIRST_OBJECT
    assert mine.sum() > 500
    assert (view.targets[mine] == -1).all()


def test_every_field_of_the_words_is_checked():
    for name in set(CHOICES) - {"bystander"}:
        with pytest.raises(ValueError, match=rf"Surroundings\.{name} must be one of .*'marble'"):
            build(scene_with(replace(PLAIN, **{name: "marble"})))
    assert {f.name for f in fields(Surroundings)} >= CHOICES.keys()


def test_soft_shadows_are_the_same_whether_all_or_a_part_is_drawn():
    scene = scene_with(PLAIN)
    pose = rest_pose(scene.anatomy, scene.room)
    raised = rest_pose(scene.anatomy, scene.room, ((0.35, -0.3, 1.1), (0.45, 0.1, 0.85)))
    with StereoRenderer(build(scene)) as plain, StereoRenderer(build(scene), pose) as still:
        whole, part = (_colours(renderer, raised) for renderer in (plain, still))
    steps = np.abs(whole.astype(int) - part).max(axis=-1)
    assert (steps > 2).mean() < 2e-4
    sharp = scene_with(replace(PLAIN, light_softness=0.0))
    with StereoRenderer(build(sharp)) as renderer:
        other = _colours(renderer, raised)
    softened = np.abs(whole.astype(int) - other).max(axis=-1) > 8
    assert 0.001 < softened.mean() < 0.1, "the edges of shadows, and only these"


@pytest.mark.long
def test_a_second_light_casts_shadows_of_its_own():
    """Both lights' shadows lie on the table, each where the other's light still reaches."""
    two = scene_with(replace(PLAIN, shadow_lights=2, light_softness=0.0, light_contrast=0.0))
    pose = rest_pose(two.anatomy, two.room)
    raised = rest_pose(two.anatomy, two.room, ((0.35, -0.3, 1.1), (0.45, 0.1, 0.85)))
    world = build(two)
    casting = np.flatnonzero(world.model.light_castshadow)
    assert len(casting) == 2
    with StereoRenderer(world) as plain, StereoRenderer(world, pose) as still:
        both, part = (_colours(renderer, raised) for renderer in (plain, still))
    assert (np.abs(both.astype(int) - part).max(axis=-1) > 2).mean() < 2e-4
    shadows = []
    for light in casting:
        world.model.light_castshadow[casting] = 1
        world.model.light_castshadow[light] = 0
        with StereoRenderer(world) as renderer:
            shadows.append(
                _colours(renderer, raised).astype(int).sum(axis=-1) - both.sum(axis=-1) > 12
            )
    first, second = shadows
    assert first.mean() > 0.004
    assert second.mean() > 0.004
    assert (first & ~second).mean() > 0.002
    assert (second & ~first).mean() > 0.002


def _colours(renderer, pose):
    renderer.world.place(pose)
    return renderer.view(0, labels=False, amodal=False).colour
