"""Identity: alike for the same room, body and rig, different where one thing of it differs."""

from dataclasses import replace

from sim.anatomy import Anatomy
from sim.scene.identity import identity_of
from sim.specs import ObjectSpec, RigSpec, RoomSpec, SceneSpec

SCENE = SceneSpec()
CAN = ObjectSpec("can", "can", (0.07, 0.07, 0.1), (0.7, 0.1, 0.1), (0.5, 0.0))


def test_each_part_has_a_digest_of_its_own():
    plain = identity_of(SCENE)
    assert identity_of(SceneSpec()) == plain
    other_room = identity_of(replace(SCENE, room=RoomSpec(texture_seed=1)))
    assert (other_room.body, other_room.rig) == (plain.body, plain.rig)
    assert other_room.room != plain.room
    other_rig = identity_of(replace(SCENE, rig=RigSpec(focal_px=541.0)))
    assert other_rig == replace(plain, rig=other_rig.rig)
    assert other_rig.rig != plain.rig
    other_body = identity_of(replace(SCENE, anatomy=Anatomy.of(1.6)))
    assert other_body == replace(plain, body=other_body.body)
    assert other_body.body != plain.body


def test_the_objects_of_a_motion_are_no_part_of_the_room():
    with_can = replace(SCENE, room=replace(SCENE.room, objects=(CAN,)))
    assert identity_of(with_can) == identity_of(SCENE)
