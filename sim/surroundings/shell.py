"""Walls, floor and ceiling of a room, and the frames in which things hang on its walls."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from sim.specs import RoomSpec, Surroundings
from sim.surfaces.assets import Assets, Quaternion, turned
from sim.surfaces.wall_textures import FLOORS, WALLS

HEIGHT_M, FRONT_M = 2.62, 2.6  # of the ceiling; how far the room reaches before the person
FACING: Quaternion = (0.5, 0.5, 0.5, 0.5)  # a plane's x, y, z to y, z, x
_DOWN: Quaternion = (0.0, 1.0, 0.0, 0.0)


@dataclass(frozen=True, eq=False)
class Wall:
    """A wall's frame: x out of it into the room, y along it, z up from the floor.

    ends_m: where it begins and ends along y, as far as the cameras may see it.
    """

    name: str
    body: Any
    ends_m: tuple[float, float]


def add_shell(assets: Assets, room: RoomSpec, around: Surroundings) -> tuple[Wall, Wall, Wall]:
    """Add floor, ceiling and walls; returns the back wall, the right and the left one."""
    world, W, back = assets.spec.worldbody, around.half_width_m, -around.depth_m
    length = FRONT_M - back
    middle_x = (FRONT_M + back) / 2
    floor = assets.texture("floor", FLOORS[around.floor], around.floor_rgb, (length, 2 * W))
    assets.painted("floor", floor, specular=0.04 if around.floor != "carpet" else 0.0)
    # The plane's x runs along the room's breadth, as the boards do.
    assets.plane(world, "floor", (middle_x, 0, 0), (W, length / 2), turned(np.pi / 2), "floor")
    assets.plain("ceiling", (0.80, 0.80, 0.79), specular=0.0)
    assets.plane(world, "ceiling", (middle_x, 0, HEIGHT_M), (length / 2, W), _DOWN, "ceiling")
    rng = assets.rng("shell")
    accent = rng.random() < 0.4  # the back wall alone is papered, the others are painted
    assets.plain("trim", _pale(rng), specular=0.05)
    walls = []
    deep = around.depth_m + 0.6  # of the side walls, as far as the cameras may see them
    for name, at, yaw, ends, seen in (
        ("back", (back, 0.0, 0.0), 0.0, (-W, W), (-W, W)),
        ("right", (back, -W, 0.0), np.pi / 2, (-length, 0.0), (-deep, 0.0)),
        ("left", (back, W, 0.0), -np.pi / 2, (0.0, length), (0.0, deep)),
    ):
        body = world.add_body(name=f"wall:{name}", pos=list(at), quat=list(turned(float(yaw))))
        size = (HEIGHT_M, ends[1] - ends[0])
        kind = "paint" if accent and name != "back" else around.wall
        assets.painted(
            f"wall:{name}",
            assets.texture(f"wall:{name}", WALLS[kind], room.wall_rgb, size),
            specular=0.0,
        )
        middle = (ends[0] + ends[1]) / 2
        half = (size[1] / 2, size[0] / 2)
        at_m = (0.0, middle, HEIGHT_M / 2)
        assets.plane(body, f"wall:{name}", at_m, half, FACING, f"wall:{name}")
        for part, z, high in (("skirting", 0.05, 0.05), ("cornice", HEIGHT_M - 0.03, 0.03)):
            at_m, half_m = (0.007, middle, z), (0.007, size[1] / 2, high)
            assets.box(body, f"{part}:{name}", at_m, half_m, "trim", castshadow=False)
        walls.append(Wall(name, body, seen))
    return walls[0], walls[1], walls[2]


def _pale(rng: np.random.Generator) -> tuple[float, float, float]:
    light, warm = float(rng.uniform(0.62, 0.84)), float(rng.uniform(0.0, 0.04))
    return light, light - 0.3 * warm, light - warm
