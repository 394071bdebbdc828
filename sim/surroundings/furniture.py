"""Furniture that stands at a wall or on the floor, not in the person's reach."""

from __future__ import annotations

import numpy as np

from sim.surfaces import textures
from sim.surfaces.assets import Assets
from sim.surfaces.blocks import block
from sim.surfaces.shapes import revolved
from sim.surroundings.on_walls import add_books, colour_of
from sim.surroundings.plants import add_plant
from sim.surroundings.shell import Wall
from sim.vectors import about_z

_WOODS = ((0.40, 0.29, 0.20), (0.30, 0.22, 0.16), (0.55, 0.47, 0.37), (0.22, 0.20, 0.19))


def add_bookcase(assets: Assets, wall: Wall, y: float, width_m: float) -> None:
    """Add an open case with boards full of books and boxes."""
    tag = f"bookcase:{wall.name}"
    rng = assets.rng(tag)
    _case(assets, tag, rng)
    boards = int(rng.integers(4, 6))
    pitch = float(rng.uniform(0.33, 0.38))
    high, half = boards * pitch + 0.06, width_m / 2
    for side in (-1, 1):
        at, size = (0.15, y + side * half, high / 2), (0.15, 0.012, high / 2)
        assets.box(wall.body, f"{tag}:side:{side}", at, size, tag, castshadow=False)
    assets.plain(f"{tag}:back", (0.20, 0.18, 0.17))
    back = (0.012, y, high / 2)
    assets.box(
        wall.body, f"{tag}:back", back, (0.006, half, high / 2), f"{tag}:back", castshadow=False
    )
    for i in range(boards + 1):
        z = 0.05 + i * pitch
        at, size = (0.15, y, z), (0.15, half, 0.012)
        assets.box(wall.body, f"{tag}:board:{i}", at, size, tag, castshadow=False)
        if i == boards:
            break
        z += 0.012
        if rng.random() < 0.75:
            add_books(assets, wall, tag, (y - half + 0.02, y + half - 0.14), z, 0.20)
        else:
            for number in range(2):
                name = f"{tag}:box:{i}:{number}"
                assets.plain(name, colour_of(rng, 0.2, 0.8, 0.5))
                at = (0.17, y + (number - 0.5) * half, z + 0.09)
                size = (0.11, 0.4 * half, 0.09)
                assets.box(wall.body, name, at, size, name, castshadow=False)


def add_cupboard(assets: Assets, wall: Wall, y: float, width_m: float) -> None:
    """Add a low cupboard with doors, and a plant or a vase on it."""
    tag = f"cupboard:{wall.name}"
    rng = assets.rng(tag)
    _case(assets, tag, rng)
    high, half = float(rng.uniform(0.75, 1.05)), width_m / 2
    top = (0.21, y, high - 0.015)
    assets.box(wall.body, f"{tag}:top", top, (0.22, half + 0.01, 0.015), tag, castshadow=False)
    assets.box(
        wall.body,
        tag,
        (0.20, y, high / 2 - 0.01),
        (0.20, half, high / 2 - 0.02),
        tag,
        castshadow=False,
    )
    assets.plain(f"{tag}:gap", (0.07, 0.06, 0.06))
    assets.plain(f"{tag}:knob", (0.55, 0.54, 0.50), specular=0.4, shininess=0.6)
    doors = 2 if width_m < 0.9 else 3
    for i in range(1, doors):
        at = (0.4005, y - half + 2 * half * i / doors, high / 2)
        assets.box(
            wall.body,
            f"{tag}:gap:{i}",
            at,
            (0.0008, 0.0025, high / 2 - 0.05),
            f"{tag}:gap",
            castshadow=False,
        )
    for i in range(doors):
        at = (0.412, y - half + 2 * half * (i + 0.88) / doors, 0.62 * high)
        assets.ellipsoid(wall.body, f"{tag}:knob:{i}", at, (0.012, 0.012, 0.012), f"{tag}:knob")
    place = (0.20, y + float(rng.uniform(-0.4, 0.4)) * half, high)
    if rng.random() < 0.5:
        add_plant(assets, wall.body, f"{tag}:plant", place, float(rng.uniform(0.25, 0.42)), False)
    else:
        add_vase(assets, wall, f"{tag}:vase", place, float(rng.uniform(0.16, 0.30)))


def add_vase(
    assets: Assets, wall: Wall, name: str, at_m: tuple[float, float, float], height_m: float
) -> None:
    """Add a vase of this height with its foot at at_m in the wall's frame."""
    rng = assets.rng(name)
    belly, neck = rng.uniform(0.22, 0.34), rng.uniform(0.10, 0.18)
    outside = [[0.55 * belly, 0], [belly, 0.3], [0.9 * belly, 0.5], [neck, 0.8], [1.25 * neck, 1]]
    profile = np.array([[0, 0], *outside, [neck, 1.0], [0, 0.8]])
    assets.plain(name, colour_of(rng, 0.15, 0.85, 0.3), specular=0.3, shininess=0.5)
    surface = revolved(profile * height_m, 22)
    assets.add(wall.body, name, surface, name, 0, pos=at_m, castshadow=False)


def add_standing_lamp(assets: Assets, wall: Wall, y: float) -> None:
    """Add a lamp on a stand with a shade that glows."""
    tag = f"lamp:{wall.name}"
    rng = assets.rng(tag)
    x, high = 0.28, float(rng.uniform(1.45, 1.7))
    assets.plain(tag, (0.10, 0.10, 0.11), specular=0.3, shininess=0.5)
    assets.capsule(wall.body, tag, ((x, y, 0.02), (x, y, high)), 0.011, tag, castshadow=False)
    foot = np.array([[0, 0], [0.14, 0], [0.14, 0.012], [0.02, 0.03], [0, 0.03]])
    assets.add(
        wall.body, f"{tag}:foot", revolved(foot, 24), tag, 0, pos=(x, y, 0.0), castshadow=False
    )
    wide = float(rng.uniform(0.15, 0.22))
    shade = np.array([[wide, 0], [0.6 * wide, 0.26], [0.57 * wide, 0.26], [wide - 0.006, 0.004]])
    assets.plain(f"{tag}:shade", (0.90, 0.84, 0.72), emission=0.75)
    surface = revolved(np.concatenate([shade, shade[:1]]), 24)
    assets.add(
        wall.body,
        f"{tag}:shade",
        surface,
        f"{tag}:shade",
        0,
        pos=(x, y, high - 0.12),
        castshadow=False,
    )


def add_boxes(assets: Assets, wall: Wall, number: int, y: float) -> None:
    """Add cartons, a bin or a bag on the floor before the wall."""
    tag = f"floor:{wall.name}:{number}"
    rng = assets.rng(tag)
    kind = int(rng.integers(3))
    if kind == 0:
        z, x = 0.0, float(rng.uniform(0.25, 0.35))
        for i in range(int(rng.integers(1, 4))):
            assets.plain(f"{tag}:{i}", colour_of(rng, 0.25, 0.6, 0.8), specular=0.02)
            size = (
                float(rng.uniform(0.26, 0.34)),
                float(rng.uniform(0.3, 0.42)),
                float(rng.uniform(0.2, 0.34)),
            )
            quat = assets.quaternion(about_z(float(rng.uniform(-0.15, 0.15))))
            surface = block(size, edge_m=0.006)
            assets.add(
                wall.body,
                f"{tag}:{i}",
                surface,
                f"{tag}:{i}",
                0,
                pos=(x, y, z),
                quat=quat,
                castshadow=False,
            )
            z += size[2]
    elif kind == 1:
        profile = np.array(
            [[0, 0], [0.11, 0], [0.14, 0.34], [0.132, 0.34], [0.105, 0.02], [0, 0.02]]
        )
        assets.plain(tag, colour_of(rng, 0.1, 0.6, 0.7), specular=0.1)
        assets.add(
            wall.body, tag, revolved(profile, 24), tag, 0, pos=(0.22, y, 0.0), castshadow=False
        )
    else:
        add_plant(assets, wall.body, tag, (0.35, y, 0.0), float(rng.uniform(0.5, 0.9)), False)


def _case(assets: Assets, tag: str, rng: np.random.Generator) -> None:
    if rng.random() < 0.6:
        rgb = _WOODS[int(rng.integers(len(_WOODS)))]
        picture = assets.texture(tag, textures.wood, rgb, planks=1, size=256)
        assets.painted(tag, picture, specular=0.06)
    else:
        assets.plain(tag, colour_of(rng, 0.3, 0.85, 0.75), specular=0.08)
