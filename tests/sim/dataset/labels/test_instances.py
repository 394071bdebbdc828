"""Instance ids: what pixels show them."""

from dataclasses import replace

import numpy as np
import pytest

from pjpdaf.targets import TARGETS
from sim.camera.render import StereoRenderer
from sim.dataset.labels.instances import (
    FIRST_OBJECT,
    MAX_ID,
    NOTHING,
    PERSON,
    ROOM,
    TABLE,
    instances_of,
)
from sim.person.rest import rest_pose
from sim.pose import Transform
from sim.scene.objects import KINDS
from sim.scene.world import build
from sim.specs import Appearance, ObjectSpec, RigSpec, RoomSpec, SceneSpec

# Names that could be taken for other things.
THINGS = tuple(
    ObjectSpec(f"table {kind}", kind, (0.09, 0.09, 0.10), (0.1, 0.4, 0.5), (0.55, 0.09 * i - 0.55))
    for i, kind in enumerate(KINDS)
)
SCENE = SceneSpec(
    rig=RigSpec(tilt_rad=0.28, width_px=320, height_px=240, focal_px=270.0),
    appearance=Appearance(sleeves="rolled", glasses=True),
    room=RoomSpec(objects=THINGS),
)


@pytest.fixture(scope="module")
def world():
    return build(SCENE)


@pytest.fixture(scope="module")
def renderer(world):
    with StereoRenderer(world) as opened:
        yield opened


def ids_of(world, renderer, **changed):
    world.place(rest_pose(SCENE.anatomy))
    geoms = renderer.view(0, colour=False, amodal=False, **changed).geoms
    return instances_of(world).ids(geoms)


def test_the_table_names_every_id_in_use_once(world):
    instances = instances_of(world)
    known = [one.id for one in instances.table]
    assert len(set(known)) == len(known)
    assert set(instances.of_geom.tolist()) <= {NOTHING, *known}
    assert instances.highest == FIRST_OBJECT + len(THINGS) - 1
    names = [one.name for one in instances.table if one.kind == "object"]
    assert names == [thing.name for thing in THINGS]
    assert [one.name for one in instances.table if one.kind == "target"] == list(TARGETS)


def test_targets_are_the_skin_that_the_truth_counts(world, renderer):
    world.place(rest_pose(SCENE.anatomy))
    view = renderer.view(0, colour=False, amodal=False)
    ids = instances_of(world).ids(view.geoms)
    assert ids.dtype == np.uint8
    for target in range(len(TARGETS)):
        np.testing.assert_array_equal(ids == 1 + target, view.targets == target)
    np.testing.assert_array_equal(ids == NOTHING, view.geoms < 0)


def test_without_the_person_no_pixel_is_the_persons(world, renderer):
    with_her, without = ids_of(world, renderer), ids_of(world, renderer, person=False)
    person = (with_her >= 1) & (with_her <= PERSON)
    assert (with_her == PERSON).mean() > 0.05
    assert not ((without >= 1) & (without <= PERSON)).any()
    np.testing.assert_array_equal(with_her[~person], without[~person])
    assert {ROOM, TABLE} <= set(np.unique(without).tolist())


def test_each_object_is_the_pixels_that_go_with_it(world, renderer):
    before = ids_of(world, renderer)
    far = Transform(np.array([0.5, 0.0, -9.0]), np.eye(3))
    pose = rest_pose(SCENE.anatomy)
    for k, thing in list(enumerate(THINGS))[4:8]:
        world.place(replace(pose, objects={thing.name: far}))
        geoms = renderer.view(0, colour=False, amodal=False).geoms
        after = instances_of(world).ids(geoms)
        changed = after != before
        np.testing.assert_array_equal(changed, before == FIRST_OBJECT + k)
        assert changed.sum() > 20
        stands = np.array([*thing.position_xy_m, SCENE.room.table_height_m])
        world.place(replace(pose, objects={thing.name: Transform(stands, np.eye(3))}))


def test_of_nothing_is_nothing(world):
    assert instances_of(world).ids(np.array([[-1]], np.int32)).tolist() == [[NOTHING]]


def test_more_objects_than_a_byte_counts_are_refused(world):
    many = tuple(replace(THINGS[0], name=str(i)) for i in range(MAX_ID - FIRST_OBJECT + 2))
    crowded = replace(world, scene=replace(SCENE, room=RoomSpec(objects=many)))
    with pytest.raises(ValueError, match="at most 246 objects"):
        instances_of(crowded)
