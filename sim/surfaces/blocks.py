"""Blocks with rounded edges as surfaces (numpy only)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pjpdaf.arrays import Floats
from sim.surfaces.shapes import Surface, capped, closed_grid

_CORNER_POINTS, _EDGE_RINGS = 4, 4


def block(
    size_m: tuple[float, float, float], edge_m: float = 0.003, corner_m: float = 0.0
) -> Surface:
    """A block on the plane z = 0, centred, with this extent along x, y, z.

    edge_m rounds all edges, corner_m the four upright ones if that is more; both are cut to what
    the block has room for. The texture runs round the sides, and lies flat on top and bottom, with
    u along the longer of x and y; it spans the longest extent once.
    """
    sx, sy, sz = size_m
    edge = min(edge_m, 0.45 * min(size_m))
    corner = min(max(corner_m, edge), 0.49 * min(sx, sy))
    angle = np.linspace(0, np.pi / 2, _EDGE_RINGS)
    inset, drop = edge * (1 - np.sin(angle)), edge * (1 - np.cos(angle))
    # The flat faces have rings of their own, so that their normals are theirs alone.
    insets = np.concatenate([[edge], inset, inset[::-1], [edge]])
    z = np.concatenate([[sz], sz - drop, drop[::-1], [0.0]])
    rings = [_outline(sx / 2 - d, sy / 2 - d, max(corner - d, 1e-5)) for d in insets]
    grid = np.dstack([np.array(rings), np.repeat(z[:, None], len(rings[0]), axis=1)])
    grid = capped(grid)
    surface = closed_grid(grid)
    span = max(size_m)
    x, y, height = np.moveaxis(grid, -1, 0)
    flat = np.stack([x, y] if sx >= sy else [y, -x], axis=-1) / span + 0.5
    way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(rings[2], axis=0), axis=1))])
    sides = np.dstack([np.broadcast_to(way / span, height.shape), 1 - height / span])
    sides[:2], sides[-2:] = flat[:2], flat[-2:]
    return replace(surface, uv=sides.reshape(-1, 2))


def _outline(half_x: float, half_y: float, corner: float) -> Floats:
    """A rectangle with round corners, counter-clockwise, closed (k, 2)."""
    turn = np.linspace(0, np.pi / 2, _CORNER_POINTS)
    points = []
    for quarter, (sx, sy) in enumerate(((1, 1), (-1, 1), (-1, -1), (1, -1))):
        angle = turn + quarter * np.pi / 2
        centre = [sx * (half_x - corner), sy * (half_y - corner)]
        points.append(centre + corner * np.column_stack([np.cos(angle), np.sin(angle)]))
    ring = np.concatenate(points)
    return np.concatenate([ring, ring[:1]])
