"""Semantic classes of surfaces: parts of the person, objects, parts of the room."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from pjpdaf.targets import HEAD
from sim.person.geoms import HAND_TARGETS
from sim.scene.world import World

# By id; a new class comes at the end.
CLASSES = (
    *("nothing", "face", "neck", "hair", "glasses", "hand", "arm", "clothes"),
    *("object", "table", "floor", "wall", "door", "window", "picture", "shelf", "chair"),
    *("plant", "lamp", "screen", "other_person", "clutter", "ceiling"),
)
# Classes that together are what other data sets call by one name.
CLASS_GROUPS: dict[str, tuple[str, ...]] = {
    "facial_skin": ("face",),
    "whole_head": ("face", "hair", "glasses"),
    "target_head": ("face", "neck"),
    "skin": ("face", "neck", "hand", "arm"),
    "person": ("face", "neck", "hair", "glasses", "hand", "arm", "clothes"),
}
# Of the room, by the first word of a geom's name; anything else is clutter.
_ROOM = {
    "floor": "floor",
    "rug": "floor",
    **dict.fromkeys(("wall", "skirting", "cornice"), "wall"),
    "ceiling": "ceiling",
    **dict.fromkeys(("jamb", "lintel", "door", "panel", "handle"), "door"),
    **dict.fromkeys(("window", "blind", "curtain", "sill"), "window"),
    **dict.fromkeys(("frame", "mat", "painting", "picture", "poster"), "picture"),
    **dict.fromkeys(("shelf", "board", "bookcase", "cupboard"), "shelf"),
    **dict.fromkeys(("seat", "chair"), "chair"),
    "table": "table",
    "plant": "plant",
    **dict.fromkeys(("lamp", "ceiling_lamp"), "lamp"),
    "screen": "screen",
}
# Of things that stand on others, by the last word of a geom's name.
_STANDING = {**dict.fromkeys(("leaf", "stem", "pot", "soil"), "plant"), "vase": "clutter"}
_ARMS = ("upper_arm", "forearm")


def class_id(name: str) -> int:
    """The id of a class."""
    return CLASSES.index(name)


def classes_of(world: World) -> NDArray[np.uint8]:
    """The class of each geom of a world (ngeom + 1,); the last is of no geom (-1)."""
    model = world.model
    names = [_class_of(world, geom) for geom in range(model.ngeom)]
    return np.array([*(class_id(name) for name in names), class_id("nothing")], np.uint8)


def _class_of(world: World, geom: int) -> str:
    model = world.model
    name, body = model.geom(geom).name, model.body(int(model.geom_bodyid[geom])).name
    target = int(world.targets[geom])
    if target == HEAD:
        return "neck" if "neck" in name else "face"
    if target in HAND_TARGETS:
        return "hand"
    if int(model.geom_group[geom]) in world.person_groups:
        return _class_of_person(_material(model, geom), body)
    if body.startswith("object:"):
        return "other_person" if body.removeprefix("object:") in _people(world) else "object"
    standing = [word for word in name.split(":") if word in _STANDING]
    return _STANDING[standing[-1]] if standing else _ROOM.get(name.partition(":")[0], "clutter")


def _people(world: World) -> set[str]:
    """Names of the objects that are people."""
    assert world.scene is not None, "only a scene with a person has classes"
    return {spec.name for spec in world.scene.room.objects if spec.kind == "bystander"}


def _class_of_person(material: str, body: str) -> str:
    """The class of a geom of the person that is no target's skin."""
    if material.startswith("hair"):
        return "hair"
    if material == "frame":
        return "glasses"
    if not material.startswith("skin"):
        return "clothes"
    # Cores, which cast shadows within the skin, and the bare skin of arms.
    if body == "head":
        return "face"
    return "arm" if body.partition(":")[0] in _ARMS else "hand"


def _material(model: Any, geom: int) -> str:
    number = int(model.geom_matid[geom])
    return str(model.mat(number).name) if number >= 0 else ""
