"""Procedural walls and floors at their true scale: uint8 RGB (h, w, 3).

size_m: height and width of the surface, which the texture spans once, so that nothing repeats but
what does in a real room: the print of a wallpaper, bricks, boards, tiles.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from pjpdaf.arrays import Floats
from sim.specs import RGB
from sim.surfaces.textures import Texture, second_colour, shade, soft, to_bytes, value_noise

Size = tuple[float, float]
_PX_PER_M = 200.0
_MOST_PX = 1000
Paint = Callable[[np.random.Generator, RGB, Size], Texture]


def _shape(size_m: Size) -> tuple[int, int]:
    scale = min(_PX_PER_M, _MOST_PX / max(size_m))
    return max(round(size_m[0] * scale), 8), max(round(size_m[1] * scale), 8)


def _places(size_m: Size) -> tuple[tuple[int, int], Floats, Floats]:
    """Shape, and for each pixel its place [m]: from the top, and from the left."""
    shape = _shape(size_m)
    down, along = np.meshgrid(
        np.linspace(0, size_m[0], shape[0]), np.linspace(0, size_m[1], shape[1]), indexing="ij"
    )
    return shape, down, along


def _light(rng: np.random.Generator, down: Floats, along: Floats) -> Floats:
    """Unevenness of a wall's light: darker in corners and at the floor, brighter to one side."""
    height, width = float(down.max()), float(along.max())
    to_side = rng.uniform(-0.10, 0.10) * (2 * along / width - 1)
    corners = np.exp(-along / 0.25) + np.exp(-(width - along) / 0.25)
    ends = 0.8 * np.exp(-(height - down) / 0.30) + 0.6 * np.exp(-down / 0.22)
    return np.asarray(1 + to_side - 0.10 * corners - 0.13 * ends)


def paint(rng: np.random.Generator, rgb: RGB, size_m: Size) -> Texture:
    """Painted plaster; in half of the rooms the lower part, to a rail, has a second colour."""
    shape, down, along = _places(size_m)
    bumps = 0.012 * rng.standard_normal(shape) + 0.013 * value_noise(rng, shape, (90, 160))
    light = _light(rng, down, along) * (1 + bumps + 0.015 * value_noise(rng, shape, (4, 6)))
    colour = np.broadcast_to(np.array(rgb), (*shape, 3))
    if size_m[0] > 2.0 and rng.random() < 0.3:
        rail = size_m[0] - rng.uniform(0.85, 1.15)
        lower = np.array(rgb) * rng.uniform(0.55, 0.8, 3)
        colour = np.where((down > rail)[..., None], lower, colour)
        edge = np.abs(down - rail) < 0.025
        colour = np.where(edge[..., None], np.array([0.78, 0.77, 0.74]), colour)
        light = light * (1 - 0.25 * soft(0.010 - np.abs(down - rail - 0.033), 0.006))
    return to_bytes(colour * light[..., None])


def wallpaper(rng: np.random.Generator, rgb: RGB, size_m: Size) -> Texture:
    """Wallpaper: stripes, a lattice of leaves, dots, or large waves, in two inks."""
    shape, down, along = _places(size_m)
    ground, ink = np.array(rgb), second_colour(np.array(rgb))
    ink = ground + (ink - ground) * rng.uniform(0.25, 0.75)
    kind = str(rng.choice(["stripes", "leaves", "dots", "waves", "lattice"]))
    pitch = float(rng.uniform(0.10, 0.26))
    if kind == "stripes":
        phase = along / pitch * 2 * np.pi
        share = soft(np.sin(phase), 0.25) + 0.5 * soft(np.sin(phase * 3 + 1.0) - 0.86, 0.1)
    elif kind == "waves":
        phase = along / pitch + 0.35 * np.sin(2 * np.pi * down / (2.3 * pitch))
        share = soft(np.sin(2 * np.pi * phase), 0.5)
    else:
        row = np.floor(down / pitch)
        u = np.mod(along / pitch + 0.5 * np.mod(row, 2), 1.0) - 0.5
        v = np.mod(down / pitch, 1.0) - 0.5
        r, turn = np.hypot(u, v), np.arctan2(v, u)
        if kind == "dots":
            share = soft(rng.uniform(0.12, 0.24) - r, 0.03)
        elif kind == "leaves":
            petals = int(rng.integers(4, 8))
            share = soft(0.30 * (0.55 + 0.45 * np.cos(petals * turn)) - r, 0.03)
            share = share * (1 - 0.7 * soft(0.05 - r, 0.02))
        else:
            share = soft(0.045 - np.abs(np.abs(u) + np.abs(v) - 0.5), 0.03)
            share = np.maximum(share, soft(0.07 - r, 0.02))
    sheet = 0.53  # a roll's width: its seams show faintly
    seams = soft(0.0025 - np.abs(np.mod(along, sheet) - 0.01), 0.002)
    grain = 1 + 0.012 * rng.standard_normal(shape) - 0.05 * seams
    colour = ground + (ink - ground) * np.clip(share, 0, 1)[..., None]
    return to_bytes(colour * (grain * _light(rng, down, along))[..., None])


def brick(rng: np.random.Generator, rgb: RGB, size_m: Size) -> Texture:
    """A brick wall, bare in its own red or grey, or painted over in the wall's colour."""
    shape, down, along = _places(size_m)
    height, width = 0.075, 0.225
    row = np.floor(down / height).astype(int)
    at = along / width + 0.5 * (row % 2) + 0.03 * np.sin(row * 2.4)
    number = np.floor(at).astype(int)
    u, v = (at - number) * width, np.mod(down, height)
    inside = np.minimum.reduce([u, width - u, v, height - v])
    joint = soft(0.006 - inside + 0.0015 * value_noise(rng, shape, (200, 300)), 0.004)
    painted = rng.random() < 0.5
    kinds = rng.normal(size=(int(row.max()) + 1, int(number.max()) + 1, 3))
    each = kinds[row, number]
    if painted:
        ground = np.array(rgb) * (1 + 0.02 * each[..., :1])
        mortar = np.array(rgb) * 0.86
    else:
        base = np.array([[0.47, 0.24, 0.18], [0.52, 0.45, 0.40], [0.40, 0.30, 0.27]])
        ground = base[rng.integers(len(base))] * (1 + 0.13 * each[..., :1] + 0.03 * each)
        mortar = np.array([0.60, 0.58, 0.55])
    rough = 1 + 0.05 * rng.standard_normal(shape) + 0.05 * value_noise(rng, shape, (120, 200))
    relief = 1 + 0.10 * soft(0.010 - v, 0.006) - 0.16 * soft(0.010 - (height - v), 0.006)
    colour = ground + (mortar - ground) * joint[..., None]
    return to_bytes(colour * (rough * relief * _light(rng, down, along))[..., None])


def panel(rng: np.random.Generator, rgb: RGB, size_m: Size) -> Texture:
    """Upright boards: of wood, or painted, to the ceiling or to a rail under paint."""
    shape, down, along = _places(size_m)
    broad = float(rng.uniform(0.09, 0.22))
    number = np.floor(along / broad).astype(int)
    each = rng.normal(size=number.max() + 1)
    u = np.mod(along, broad)
    groove = soft(0.004 - np.minimum(u, broad - u), 0.003)
    wooden = rng.random() < 0.6
    woods = np.array([[0.42, 0.31, 0.22], [0.30, 0.21, 0.15], [0.56, 0.50, 0.42]])
    colour = woods[rng.integers(len(woods))] if wooden else np.array(rgb)
    fibre = value_noise(rng, (shape[0], shape[1]), (12, shape[1] // 2))
    rings = np.sin(
        2 * np.pi * (3.0 * u / broad + 0.35 * value_noise(rng, shape, (5, 30)) + each[number])
    )
    grain = 1 + (0.05 * fibre + 0.03 * rings if wooden else 0.012 * fibre)
    light = grain * (1 + (0.07 if wooden else 0.02) * each[number]) * (1 - 0.45 * groove)
    boards = colour * light[..., None]
    if rng.random() < 0.5 and size_m[0] > 2.0:
        rail = size_m[0] - float(rng.uniform(0.95, 1.5))
        above = np.array(rgb) * (1 + 0.012 * rng.standard_normal(shape))[..., None]
        boards = np.where((down < rail)[..., None], above, boards)
        strip = np.abs(down - rail) < 0.03
        boards = np.where(strip[..., None], colour * 1.08, boards)
        boards = boards * (1 - 0.3 * soft(0.012 - np.abs(down - rail - 0.04), 0.008))[..., None]
    return to_bytes(boards * _light(rng, down, along)[..., None])


def carpet(rng: np.random.Generator, rgb: RGB, size_m: Size) -> Texture:
    """A carpet from wall to wall, with or without a rug's border."""
    shape, down, along = _places(size_m)
    light = 1 + 0.08 * rng.standard_normal(shape) + 0.04 * value_noise(rng, shape, (12, 16))
    colour = np.broadcast_to(np.array(rgb), (*shape, 3))
    if rng.random() < 0.5:
        inset = np.minimum.reduce([down, size_m[0] - down, along, size_m[1] - along])
        border = soft(inset - 0.5, 0.004) * soft(0.62 - inset, 0.004)
        rug = np.array(rgb) * rng.uniform(0.5, 1.3, 3)
        colour = np.where((inset > 0.5)[..., None], rug, colour)
        colour = colour + (np.array(rgb) * 0.5 - colour) * border[..., None]
    return to_bytes(colour * light[..., None])


def planks(rng: np.random.Generator, rgb: RGB, size_m: Size) -> Texture:
    """Staggered floor boards."""
    shape, down, along = _places(size_m)
    broad, long = float(rng.uniform(0.09, 0.18)), float(rng.uniform(0.9, 1.6))
    row = np.floor(down / broad).astype(int)
    starts = rng.uniform(0, long, row.max() + 1)
    at = (along + starts[row]) / long
    number = np.floor(at).astype(int)
    each = rng.normal(size=(row.max() + 1, number.max() + 1))[row, number]
    v, u = np.mod(down, broad), (at - number) * long
    joint = soft(0.003 - np.minimum.reduce([v, broad - v, u, long - u]), 0.0025)
    fibre = value_noise(rng, shape, (shape[0] // 2, 14))
    return shade(rgb, (1 + 0.09 * each + 0.05 * fibre) * (1 - 0.5 * joint))


def tiles(rng: np.random.Generator, rgb: RGB, size_m: Size) -> Texture:
    """Square tiles with grout, plain or a chequerboard."""
    shape, down, along = _places(size_m)
    side = float(rng.uniform(0.2, 0.45))
    row, column = np.floor(down / side).astype(int), np.floor(along / side).astype(int)
    each = rng.normal(size=(row.max() + 1, column.max() + 1))[row, column]
    v, u = np.mod(down, side), np.mod(along, side)
    joint = soft(0.004 - np.minimum.reduce([v, side - v, u, side - u]), 0.003)
    light = 1 + 0.03 * each + 0.03 * value_noise(rng, shape, (30, 30))
    if rng.random() < 0.4:
        light = light * np.where((row + column) % 2 == 0, 1.0, rng.uniform(0.45, 0.8))
    return shade(rgb, light * (1 - 0.3 * joint))


WALLS: Mapping[str, Paint] = {
    "paint": paint,
    "wallpaper": wallpaper,
    "brick": brick,
    "panel": panel,
}
FLOORS: Mapping[str, Paint] = {"carpet": carpet, "planks": planks, "tiles": tiles}
