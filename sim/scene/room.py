"""The room: floor, walls, table, chair, objects on the table, lights."""

from __future__ import annotations

import numpy as np

from pjpdaf.arrays import Floats
from sim.person.geoms import ROOM
from sim.scene.objects import add_object
from sim.specs import RoomSpec
from sim.surfaces import textures
from sim.surfaces.assets import Assets, Quaternion, check_word, turned
from sim.surfaces.shapes import revolved
from sim.surroundings.lights import add_ambience, add_directional
from sim.surroundings.room import add_surroundings
from sim.surroundings.seat_and_table import TOP_M, paint_table
from sim.surroundings.shell import FACING
from sim.vectors import about_z

WALL_X, SIDE_Y, HEIGHT, FRONT_X = -1.55, 2.1, 2.7, 2.6  # the room [m]
AIM_M = np.array([0.1, 0.0, 0.95])  # the point at which the lights aim
_FROM_RIGHT: Quaternion = (0.7071068, -0.7071068, 0.0, 0.0)  # normal +y
_FROM_LEFT: Quaternion = (0.7071068, 0.7071068, 0.0, 0.0)  # normal -y


def add_room(assets: Assets, room: RoomSpec) -> None:
    """Add all that stands still, the objects (as posed bodies) and the lights."""
    check_word("RoomSpec.table_surface", room.table_surface, textures.SURFACES)
    if room.surroundings is None:
        _walls(assets, room)
        _furniture(assets)
        _table(assets, room)
        _chair(assets)
    else:
        add_surroundings(assets, room, room.surroundings, AIM_M)
    for spec in room.objects:
        add_object(assets, room, spec)
    if room.surroundings is None:
        _lights(assets, room)


def _walls(assets: Assets, room: RoomSpec) -> None:
    world = assets.spec.worldbody
    assets.painted("wall", assets.texture("wall", textures.plaster, room.wall_rgb), specular=0.0)
    floor = assets.texture("floor", textures.carpet, (0.30, 0.32, 0.35))
    assets.painted("floor", floor, specular=0.0, repeat=(4, 4))
    middle_x, half_x = (WALL_X + FRONT_X) / 2, (FRONT_X - WALL_X) / 2
    assets.plane(world, "floor", (middle_x, 0, 0), (half_x, SIDE_Y), (1, 0, 0, 0), "floor")
    z, half_z = HEIGHT / 2, HEIGHT / 2
    assets.plane(world, "wall:back", (WALL_X, 0, z), (SIDE_Y, half_z), FACING, "wall")
    assets.plane(world, "wall:right", (middle_x, -SIDE_Y, z), (half_x, half_z), _FROM_RIGHT, "wall")
    assets.plane(world, "wall:left", (middle_x, SIDE_Y, z), (half_x, half_z), _FROM_LEFT, "wall")
    assets.plain("trim", (0.74, 0.75, 0.74))
    assets.box(
        world,
        "skirting",
        (WALL_X + 0.008, 0, 0.05),
        (0.008, SIDE_Y, 0.05),
        "trim",
        castshadow=False,
    )


def _furniture(assets: Assets) -> None:
    """A painting, a door, a shelf with books: the room's landmarks, none of the colour of skin."""
    world = assets.spec.worldbody
    x = WALL_X
    assets.plain("frame:dark", (0.10, 0.10, 0.11), specular=0.15)
    assets.plain("mat", (0.80, 0.80, 0.78))
    assets.painted("painting", assets.texture("painting", textures.painting), specular=0.0)
    y, z = 0.86, 1.52
    assets.box(
        world, "frame", (x + 0.012, y, z), (0.012, 0.33, 0.25), "frame:dark", castshadow=False
    )
    assets.box(world, "mat", (x + 0.020, y, z), (0.006, 0.30, 0.22), "mat", castshadow=False)
    assets.plane(world, "painting", (x + 0.028, y, z), (0.25, 0.17), FACING, "painting")
    assets.plain("door", (0.66, 0.70, 0.72))
    assets.plain("panel", (0.60, 0.64, 0.66))
    assets.plain("metal", (0.55, 0.56, 0.58), specular=0.5, shininess=0.6)
    y = -1.05
    for side in (-1, 1):
        assets.box(
            world,
            f"jamb:{side}",
            (x + 0.015, y + 0.46 * side, 1.03),
            (0.015, 0.04, 1.03),
            "trim",
            castshadow=False,
        )
    assets.box(
        world, "lintel", (x + 0.015, y, 2.10), (0.015, 0.50, 0.045), "trim", castshadow=False
    )
    assets.box(world, "door", (x + 0.006, y, 1.02), (0.006, 0.42, 1.02), "door", castshadow=False)
    for row, (low, high) in enumerate(((0.15, 0.90), (1.08, 1.92))):
        for side in (-1, 1):
            assets.box(
                world,
                f"panel:{row}:{side}",
                (x + 0.012, y + 0.195 * side, (low + high) / 2),
                (0.004, 0.145, (high - low) / 2),
                "panel",
                castshadow=False,
            )
    assets.ellipsoid(world, "handle", (x + 0.05, y + 0.36, 1.02), (0.025, 0.028, 0.028), "metal")
    assets.plain("shelf", (0.34, 0.38, 0.42))
    y, z = 0.86, 1.10
    assets.box(world, "shelf", (x + 0.11, y, z), (0.11, 0.42, 0.012), "shelf", castshadow=False)
    rng = assets.rng("books")
    colours = (
        (0.20, 0.34, 0.30),
        (0.16, 0.22, 0.36),
        (0.58, 0.60, 0.61),
        (0.26, 0.16, 0.24),
        (0.36, 0.42, 0.46),
    )
    for i, rgb in enumerate(colours):
        assets.plain(f"book:{i}", rgb)
    at = y - 0.38
    for i in range(13):
        thick, tall = rng.uniform(0.010, 0.021), rng.uniform(0.075, 0.115)
        at += thick
        assets.box(
            world,
            f"shelf:book:{i}",
            (x + 0.09, at, z + 0.012 + tall),
            (0.075, thick * 0.95, tall),
            f"book:{int(rng.integers(len(colours)))}",
            castshadow=False,
        )
        at += thick
    vase = revolved(
        np.array(
            [
                [0.0, 0],
                [0.04, 0],
                [0.055, 0.06],
                [0.05, 0.11],
                [0.028, 0.16],
                [0.034, 0.19],
                [0.028, 0.19],
                [0.0, 0.15],
            ]
        ),
        20,
    )
    assets.plain("vase", (0.28, 0.44, 0.50), specular=0.3, shininess=0.5)
    assets.add(
        world, "vase", vase, "vase", ROOM, pos=(x + 0.11, y + 0.30, z + 0.012), castshadow=False
    )


def _table(assets: Assets, room: RoomSpec) -> None:
    world = assets.spec.worldbody
    paint_table(assets, room)
    edge = tuple(0.82 * c for c in room.table_rgb)
    assets.plain("table:edge", (edge[0], edge[1], edge[2]))
    x = room.table_near_x_m + room.table_depth_m / 2
    half = (room.table_depth_m / 2, room.table_width_m / 2)
    top = room.table_height_m
    assets.box(world, "table", (x, 0, top - TOP_M / 2 - 0.0004), (*half, TOP_M / 2), "table:edge")
    # Planks run along the table's length: the plane's x is the world's y.
    assets.plane(world, "table:top", (x, 0, top), (half[1], half[0]), turned(np.pi / 2), "table")
    assets.plain("leg", (0.20, 0.21, 0.23))
    for i, (sx, sy) in enumerate(((-1, -1), (-1, 1), (1, -1), (1, 1))):
        at = (x + sx * (half[0] - 0.06), sy * (half[1] - 0.06), (top - TOP_M) / 2)
        assets.box(world, f"table:leg:{i}", at, (0.025, 0.025, (top - TOP_M) / 2), "leg")


def _chair(assets: Assets) -> None:
    world = assets.spec.worldbody
    assets.plain("chair", (0.13, 0.15, 0.17), specular=0.1)
    assets.plain("cushion", (0.22, 0.27, 0.30))
    assets.box(world, "seat", (-0.03, 0, 0.40), (0.23, 0.23, 0.03), "cushion")
    for side in (-1, 1):
        ends = ((-0.235, 0.215 * side, 0.0), (-0.26, 0.215 * side, 0.90))
        assets.capsule(world, f"chair:post:{side}", ends, 0.017, "chair")
        ends = ((0.17, 0.2 * side, 0.0), (0.17, 0.2 * side, 0.38))
        assets.capsule(world, f"chair:leg:{side}", ends, 0.017, "chair")
    for i, z in enumerate((0.60, 0.72, 0.84)):
        assets.box(world, f"chair:slat:{i}", (-0.252, 0, z), (0.010, 0.215, 0.038), "chair")


def key_direction(azimuth_rad: float) -> Floats:
    """The way (3,) in which the key light shines, turned by this much about the vertical."""
    way: Floats = about_z(azimuth_rad) @ np.array([-0.78, -0.42, -0.80])
    return way / float(np.linalg.norm(way))


def _lights(assets: Assets, room: RoomSpec) -> None:
    """Add a light with shadows, a light without, and an ambient one, all of the same colour."""

    def lit(level: float) -> list[float]:
        return [level * room.light_gain * c for c in room.light_rgb]

    for name, along, diffuse, shadow in (
        ("key", key_direction(room.light_azimuth_rad), 0.56, True),
        ("fill", np.array([-0.90, 0.45, 0.12]), 0.20, False),
    ):
        gloss = lit(0.4 if shadow else 0.0)
        add_directional(assets, name, along, AIM_M, lit(diffuse), gloss, shadow)
    add_ambience(assets, lit(0.33))
