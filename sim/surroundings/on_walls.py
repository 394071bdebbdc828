"""Things that hang on a wall: pictures, a poster of a person, a screen, a board with books."""

from __future__ import annotations

import numpy as np

from sim.specs import RGB
from sim.surfaces.assets import Assets
from sim.surfaces.picture_textures import portrait, print_, screen
from sim.surroundings.shell import FACING, Wall

POSTER_M = (0.56, 0.79)  # breadth, height


def colour_of(rng: np.random.Generator, low: float, high: float, grey: float = 0.4) -> RGB:
    """Draw a colour between two levels, this share of it grey."""
    rgb = rng.uniform(low, high, 3)
    rgb = (1 - grey) * rgb + grey * rgb.mean()
    return float(rgb[0]), float(rgb[1]), float(rgb[2])


def add_picture(
    assets: Assets, wall: Wall, number: int, y: float, z: float, width_m: float
) -> None:
    """Add a framed picture of this breadth with its middle at y, z."""
    tag = f"picture:{wall.name}:{number}"
    rng = assets.rng(tag)
    high = width_m * float(rng.uniform(0.65, 1.35))
    half, half_z = width_m / 2, high / 2
    dark = rng.random() < 0.5
    frame: RGB = (0.09, 0.09, 0.10) if dark else colour_of(rng, 0.3, 0.8, 0.7)
    assets.plain(f"{tag}:frame", frame, specular=0.15)
    assets.box(
        wall.body,
        f"{tag}:frame",
        (0.012, y, z),
        (0.012, half, half_z),
        f"{tag}:frame",
        castshadow=False,
    )
    rim = 0.018 + 0.01 * float(rng.random())
    if rng.random() < 0.5:
        assets.plain(f"{tag}:mat", (0.82, 0.81, 0.78))
        size = (0.013, half - rim, half_z - rim)
        assets.box(wall.body, f"{tag}:mat", (0.012, y, z), size, f"{tag}:mat", castshadow=False)
        rim += 0.16 * min(half, half_z)
    assets.painted(tag, assets.texture(tag, print_), specular=0.02)
    assets.plane(wall.body, tag, (0.0262, y, z), (half - rim, half_z - rim), FACING, tag)


def add_poster(assets: Assets, wall: Wall, y: float, skin: RGB) -> None:
    """Add a poster of a person of natural size: skin that is no target's."""
    z, tag = float(assets.rng("poster:place").uniform(1.25, 1.55)), "poster"
    half = (POSTER_M[0] / 2, POSTER_M[1] / 2)
    assets.plain("poster:edge", (0.85, 0.85, 0.83))
    size = (0.002, half[0] + 0.012, half[1] + 0.012)
    assets.box(wall.body, "poster:edge", (0.002, y, z), size, "poster:edge", castshadow=False)
    assets.painted(tag, assets.texture(tag, portrait, skin), specular=0.04)
    assets.plane(wall.body, tag, (0.0045, y, z), half, FACING, tag)


def add_screen(assets: Assets, wall: Wall, y: float) -> None:
    """Add a flat screen that is on."""
    rng = assets.rng("screen")
    half = float(rng.uniform(0.42, 0.58))
    z, half_z = float(rng.uniform(1.25, 1.5)), 0.5625 * half
    assets.plain("screen:case", (0.05, 0.05, 0.055), specular=0.3, shininess=0.5)
    assets.box(
        wall.body,
        "screen:case",
        (0.03, y, z),
        (0.02, half + 0.012, half_z + 0.012),
        "screen:case",
        castshadow=False,
    )
    assets.painted("screen", assets.texture("screen", screen), specular=0.1, emission=0.45)
    assets.plane(wall.body, "screen", (0.051, y, z), (half, half_z), FACING, "screen")


def add_board(assets: Assets, wall: Wall, y: float, width_m: float, z: float) -> None:
    """Add a board on the wall with books and a vase on it."""
    tag = f"board:{wall.name}"
    rng = assets.rng(tag)
    assets.plain(tag, colour_of(rng, 0.15, 0.6, 0.7), specular=0.06)
    assets.box(wall.body, tag, (0.11, y, z), (0.11, width_m / 2, 0.012), tag, castshadow=False)
    add_books(assets, wall, tag, (y - width_m / 2 + 0.03, y + 0.3 * width_m), z + 0.012, 0.09)


def add_books(
    assets: Assets, wall: Wall, tag: str, span_m: tuple[float, float], z: float, x: float
) -> None:
    """Add upright books from one end of a span, on a board at z, x out of the wall; some lean."""
    rng = assets.rng(f"books:{tag}:{span_m[0]:.3f}:{z:.3f}")
    palette = [colour_of(rng, 0.08, 0.75, 0.35) for _ in range(7)]
    for i, rgb in enumerate(palette):
        assets.plain(f"{tag}:cover:{z:.3f}:{i}", rgb)
    at, number = span_m[0], 0
    last = span_m[0] + (span_m[1] - span_m[0]) * float(rng.uniform(0.5, 1.0))
    while at < last:
        thick, tall, deep = (
            rng.uniform(0.008, 0.024),
            rng.uniform(0.075, 0.13),
            rng.uniform(0.055, 0.08),
        )
        name = f"{tag}:book:{z:.3f}:{number}"
        cover = f"{tag}:cover:{z:.3f}:{int(rng.integers(len(palette)))}"
        middle = (x, at + float(thick), z + float(tall))
        assets.box(
            wall.body,
            name,
            middle,
            (float(deep), 0.94 * float(thick), float(tall)),
            cover,
            castshadow=False,
        )
        at += 2 * float(thick)
        number += 1
