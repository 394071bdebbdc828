"""Instances: the targets, the rest of the person, table, room and objects, by id of `seg`."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pjpdaf.targets import TARGETS
from sim.scene.world import World

NOTHING = 0  # no surface within zfar
# 1, 2, 3 are the targets' skin, in the order of TARGETS.
PERSON = 4  # the rest of the person: hair, clothes, glasses, arms above the wrist
TABLE = 5
ROOM = 6  # walls, floor, chair, lamp, ...
FIRST_OBJECT = 10
MAX_ID = 255  # ids are one byte


@dataclass(frozen=True)
class Instance:
    """An instance. kind: target, person, table, room or object."""

    id: int
    name: str
    kind: str


@dataclass(frozen=True, eq=False)
class Instances:
    """Instances of a scene. of_geom (ngeom + 1,) uint8: id of each geom, last of no geom (-1)."""

    table: tuple[Instance, ...]
    of_geom: NDArray[np.uint8]

    def ids(self, geoms: NDArray[np.int32]) -> NDArray[np.uint8]:
        """Instance ids of geom ids of any shape; -1 is nothing."""
        return np.take(self.of_geom, geoms)

    @property
    def highest(self) -> int:
        """The highest id in use."""
        return max(instance.id for instance in self.table)


def instances_of(world: World) -> Instances:
    """The instances of a world; objects are numbered in the order of the scene.

    Raises ValueError for more objects than a byte has ids.
    """
    assert world.scene is not None, "only a scene with a person has instances"
    objects = [spec.name for spec in world.scene.room.objects]
    if len(objects) > MAX_ID - FIRST_OBJECT + 1:
        raise ValueError(f"a data set has at most {MAX_ID - FIRST_OBJECT + 1} objects a scene")
    table = (
        *(Instance(1 + t, name, "target") for t, name in enumerate(TARGETS)),
        Instance(PERSON, "person", "person"),
        Instance(TABLE, "table", "table"),
        Instance(ROOM, "room", "room"),
        *(Instance(FIRST_OBJECT + i, name, "object") for i, name in enumerate(objects)),
    )
    model = world.model
    of_geom = np.full(model.ngeom + 1, ROOM, np.uint8)
    of_geom[-1] = NOTHING
    for geom in range(model.ngeom):
        body = model.body(int(model.geom_bodyid[geom])).name
        if world.targets[geom] >= 0:
            of_geom[geom] = 1 + world.targets[geom]
        elif int(model.geom_group[geom]) in world.person_groups:
            of_geom[geom] = PERSON
        elif body.startswith("object:"):
            of_geom[geom] = FIRST_OBJECT + objects.index(body.removeprefix("object:"))
        elif model.geom(geom).name.startswith("table"):
            of_geom[geom] = TABLE
    return Instances(table, of_geom)
