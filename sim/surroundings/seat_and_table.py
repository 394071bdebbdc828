"""The person's table and chair in their kinds. The drawn table lies within the one that is felt."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pjpdaf.arrays import Floats
from sim.specs import RGB, RoomSpec, Surroundings
from sim.surfaces import textures
from sim.surfaces.assets import Assets
from sim.surfaces.blocks import block
from sim.surfaces.shapes import Surface, capped, closed_grid
from sim.surroundings.on_walls import colour_of

TOP_M = 0.028  # thickness of the table top
# Radius of the far corners, over the lesser of the table's depth and half its width.
_FAR_CORNERS = {"straight": 0.0, "rounded": 0.16, "half_round": 0.92}


def add_table(assets: Assets, room: RoomSpec, around: Surroundings) -> None:
    """Add the table: straight, with rounded corners, or half round at the far side."""
    world = assets.spec.worldbody
    paint_table(assets, room)
    rng = assets.rng("table:shape")
    half = np.array([room.table_depth_m, room.table_width_m]) / 2
    near = 0.0 if around.table_shape == "straight" else 0.05
    outline = _outline(half, near, far_corner(around.table_shape, half))
    surface = _slab(outline, TOP_M, half)
    x, top = room.table_near_x_m + float(half[0]), room.table_height_m
    assets.add(world, "table:top", surface, "table", 0, pos=(x, 0.0, top - TOP_M))
    leg: RGB = colour_of(rng, 0.08, 0.35, 0.8)
    assets.plain("table:leg", leg, specular=0.12)
    z = (top - TOP_M) / 2
    inner = half * ((0.7, 0.55) if around.table_shape == "half_round" else (0.9, 0.9))
    if around.table_legs == "four":
        for i, (sx, sy) in enumerate(((-1, -1), (-1, 1), (1, -1), (1, 1))):
            at = (x + sx * float(inner[0]), sy * float(inner[1]), z)
            assets.box(world, f"table:leg:{i}", at, (0.025, 0.025, z), "table:leg")
    elif around.table_legs == "trestle":
        for side in (-1, 1):
            at = (x, side * float(inner[1]), z)
            size = (0.8 * float(inner[0]), 0.018, z)
            assets.box(world, f"table:leg:{side}", at, size, "table:leg")
    else:
        ends = ((x, 0.0, 0.05), (x, 0.0, top - TOP_M - 0.06))
        assets.capsule(world, "table:leg", ends, 0.05, "table:leg")
        foot = block((0.8 * float(half[0]), 0.8 * float(half[1]), 0.03), 0.008, 0.1)
        assets.add(world, "table:foot", foot, "table:leg", 0, pos=(x, 0.0, 0.0))


def paint_table(assets: Assets, room: RoomSpec) -> None:
    """Add the material "table" of a table's top."""
    picture = assets.texture("table", textures.tabletop, room.table_rgb, room.table_surface)
    gloss = {"wood": 0.08, "cloth": 0.0, "plain": 0.12}[room.table_surface]
    assets.painted("table", picture, specular=gloss, shininess=0.3)


def far_corner(shape: str, half_m: Floats) -> float:
    """Radius [m] of the far corners of a table of this shape and half depth and width (2,)."""
    return _FAR_CORNERS[shape] * float(min(2 * half_m[0], half_m[1]))


def corner_axes(half_m: Floats, radius_m: float) -> tuple[float, float]:
    """Half axes [m] along the depth and the width of a corner, as far as the table has room.

    A half round end is an ellipse where the table is not twice as wide as deep.
    """
    return min(radius_m, 1.9 * float(half_m[0])), min(radius_m, 0.995 * float(half_m[1]))


def _outline(half_m: Floats, near_m: float, far_m: float) -> Floats:
    """A closed outline (k, 2), counter-clockwise: corners rounded by near_m and far_m [m]."""
    points = []
    for quarter, (sx, sy, r) in enumerate(
        ((1, 1, far_m), (-1, 1, near_m), (-1, -1, near_m), (1, -1, far_m))
    ):
        rx, ry = (max(axis, 0.004) for axis in corner_axes(half_m, r))
        turn = np.linspace(0, np.pi / 2, 14) + quarter * np.pi / 2
        centre = [sx * (half_m[0] - rx), sy * (half_m[1] - ry)]
        points.append(centre + np.column_stack([rx * np.cos(turn), ry * np.sin(turn)]))
    ring = np.concatenate(points)
    return np.concatenate([ring, ring[:1]])


def _slab(outline_m: Floats, thickness_m: float, half_m: Floats) -> Surface:
    """A flat top of this outline, from z = 0 up; its texture lies flat, u along y."""
    edge = 0.003
    inside = outline_m * (1 - edge / half_m)
    rings = [
        (inside, thickness_m),
        (outline_m, thickness_m - edge),
        (outline_m, edge),
        (inside, 0.0),
    ]
    rings = [rings[0], *rings, rings[-1]]  # the flat faces have rings, and so normals, of their own
    grid = np.array([np.column_stack([ring, np.full(len(ring), z)]) for ring, z in rings])
    surface = closed_grid(capped(grid))
    x, y = surface.vertices_m[:, 0], surface.vertices_m[:, 1]
    uv = np.column_stack([0.5 + 0.5 * y / half_m[1], 0.5 - 0.5 * x / half_m[0]])
    return replace(surface, uv=uv)


def add_chair(assets: Assets, kind: str) -> None:
    """Add the person's chair: slats, padded, office, or a stool."""
    world, rng = assets.spec.worldbody, assets.rng("chair")
    frame = colour_of(rng, 0.05, 0.45, 0.7)
    assets.plain("chair", frame, specular=0.1)
    cushion = colour_of(rng, 0.08, 0.55, 0.4)
    assets.cloth("cushion", cushion)
    seat = block((0.46, 0.46, 0.06), 0.02, 0.05)
    assets.add(world, "seat", seat, "cushion", 0, pos=(-0.03, 0.0, 0.37))
    if kind == "office":
        assets.capsule(world, "chair:post", ((-0.03, 0.0, 0.06), (-0.03, 0.0, 0.37)), 0.03, "chair")
        for i in range(5):
            turn = 2 * np.pi * i / 5
            tip = (-0.03 + 0.28 * np.cos(turn), 0.28 * np.sin(turn), 0.04)
            assets.capsule(world, f"chair:foot:{i}", ((-0.03, 0.0, 0.07), tip), 0.02, "chair")
    else:
        for i, (x, y) in enumerate(((-0.235, -0.2), (-0.235, 0.2), (0.17, -0.2), (0.17, 0.2))):
            assets.capsule(world, f"chair:leg:{i}", ((x, y, 0.0), (x, y, 0.38)), 0.017, "chair")
    if kind == "slats":
        for side in (-1, 1):
            ends = ((-0.24, 0.215 * side, 0.38), (-0.265, 0.215 * side, 0.92))
            assets.capsule(world, f"chair:post:{side}", ends, 0.016, "chair")
        for i, z in enumerate((0.60, 0.73, 0.86)):
            assets.box(world, f"chair:slat:{i}", (-0.256, 0, z), (0.010, 0.215, 0.034), "chair")
    elif kind in ("padded", "office"):
        high = float(rng.uniform(0.45, 0.75))
        back = block((0.07, float(rng.uniform(0.42, 0.52)), high), 0.03, 0.03)
        assets.add(world, "chair:back", back, "cushion", 0, pos=(-0.29, 0.0, 0.46))
