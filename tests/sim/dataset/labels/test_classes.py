"""Semantic classes: every geom has one that fits its instance and its name."""

import pytest

from sim.dataset.labels.classes import CLASS_GROUPS, CLASSES, class_id, classes_of
from sim.dataset.labels.instances import FIRST_OBJECT, PERSON, ROOM, TABLE, instances_of
from sim.scene.objects import KINDS
from sim.scene.world import build
from sim.specs import Appearance, ObjectSpec, RoomSpec, SceneSpec

# Names that could be taken for other things.
THINGS = tuple(
    ObjectSpec(f"wall {kind}", kind, (0.09, 0.09, 0.10), (0.1, 0.4, 0.5), (0.55, 0.09 * i - 0.55))
    for i, kind in enumerate(KINDS)
)


@pytest.fixture(scope="module", params=["rolled", "short", "long"])
def world(request):
    appearance = Appearance(sleeves=request.param, glasses=True, hair="long")
    return build(SceneSpec(appearance=appearance, room=RoomSpec(objects=THINGS)))


def named(world):
    model = world.model
    return {model.geom(g).name: CLASSES[c] for g, c in enumerate(classes_of(world)[:-1])}


def test_classes_agree_with_the_instances(world):
    instances, classes = instances_of(world).of_geom, classes_of(world)
    assert classes[-1] == class_id("nothing")
    parts = {
        1: {"face", "neck"},
        2: {"hand"},
        3: {"hand"},
        TABLE: {"table"},
        PERSON: {"hair", "glasses", "clothes", "arm", "hand", "face"},
        ROOM: {*CLASSES[class_id("floor") :]},
    }
    for instance, allowed in parts.items():
        assert {CLASSES[c] for c in classes[instances == instance]} <= allowed
    named = {CLASSES[c] for c in classes[instances >= FIRST_OBJECT]}
    assert named == {"object", "other_person"}  # one of the kinds is a person


def test_parts_of_the_person_have_the_class_of_their_name(world):
    of = named(world)
    assert of["skin:face"] == of["skin:ear:left"] == "face"
    assert of["skin:neck"] == "neck"
    assert of["hair"] == of["hair:long"] == "hair"
    assert of["bridge"] == of["temple:left"] == of["rim:right:3"] == "glasses"
    assert of["torso"] == of["collar"] == of["thigh:left"] == "clothes"
    assert of["skin:palm:left"] == of["skin:index1:right"] == "hand"
    bare = {of[name] for name in of if name.startswith(("bare:", "wrist:"))}
    assert bare <= {"arm"}
    assert bool(bare) == ("cuff:left" not in of)
    assert {of[name] for name in of if name.startswith(("cuff:", "hem:", "upper_arm:"))} == {
        "clothes"
    }


def test_the_room_is_named(world):
    of = named(world)
    wanted = {
        "floor": "floor",
        "wall:back": "wall",
        "skirting": "wall",
        "door": "door",
        "panel:0:1": "door",
        "painting": "picture",
        "shelf:book:3": "shelf",
        "table:top": "table",
        "chair:slat:1": "chair",
        "seat": "chair",
        "vase": "clutter",
    }
    assert {name: of[name] for name in wanted} == wanted


def test_groups_are_of_classes_that_exist():
    for classes in CLASS_GROUPS.values():
        assert set(classes) < set(CLASSES)
    assert set(CLASS_GROUPS["facial_skin"]) < set(CLASS_GROUPS["whole_head"])
    assert "neck" not in CLASS_GROUPS["whole_head"]
    assert len(set(CLASSES)) == len(CLASSES) < 256
