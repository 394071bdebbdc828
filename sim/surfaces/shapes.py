"""Smooth closed surfaces as triangle meshes: lofts and limbs (numpy only)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Floats


@dataclass(frozen=True, eq=False)
class Surface:
    """A closed mesh: vertices (n, 3) [m], normals (n, 3), uv (n, 2), faces (m, 3) outwards."""

    vertices_m: Floats
    normals: Floats
    uv: Floats
    faces: NDArray[np.int32]


def closed_grid(grid_m: Floats) -> Surface:
    """A surface from a grid (rings, sides + 1, 3) whose last column repeats the first.

    The first and the last ring are points (poles) or small; rings run so that (next ring) x (next
    side) points outwards. u runs along the sides, v along the rings, both 0-1. The repeated column
    lets a texture close; its normals are shared, so that no seam is seen.
    """
    rings, columns = grid_m.shape[:2]
    points = grid_m.reshape(-1, 3)
    index = np.arange(rings * columns).reshape(rings, columns)
    a, b = index[:-1, :-1].ravel(), index[1:, :-1].ravel()
    c, d = index[1:, 1:].ravel(), index[:-1, 1:].ravel()
    faces = np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
    corners = points[faces]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    faces, cross = faces[(keep := np.linalg.norm(cross, axis=1) > 1e-12)], cross[keep]
    normals = np.zeros_like(points)
    for k in range(3):
        np.add.at(normals, faces[:, k], cross)
    shaped = normals.reshape(rings, columns, 3)
    shaped[:, 0] += shaped[:, -1]
    shaped[:, -1] = shaped[:, 0]
    for pole in (0, -1):
        if np.ptp(grid_m[pole], axis=0).max() < 1e-9:
            shaped[pole] = shaped[pole].sum(axis=0)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
    v, u = np.mgrid[0 : 1 : rings * 1j, 0 : 1 : columns * 1j]
    return Surface(points, normals, np.column_stack([u.ravel(), v.ravel()]), faces.astype(np.int32))


def superellipse(sides: int, exponent: float) -> Floats:
    """Points (sides + 1, 2) of |x|^e + |y|^e = 1, counter-clockwise from +x; 2 is a circle."""
    angle = np.linspace(0.0, 2 * np.pi, sides + 1)
    c, s = np.cos(angle), np.sin(angle)
    radius = (np.abs(c) ** exponent + np.abs(s) ** exponent) ** (-1.0 / exponent)
    return np.asarray(np.column_stack([c, s]) * radius[:, None])


def interpolate(stations: Floats, at: Floats) -> Floats:
    """Rows of a table (k, 1 + n), keyed by its ascending first column, at new keys: (len(at), n).

    Monotone cubic (Fritsch and Carlson's limiter), so that outlines do not overshoot.
    """
    x, y = stations[:, 0], stations[:, 1:]
    h = np.diff(x)[:, None]
    slope = np.diff(y, axis=0) / h
    inner = np.where(
        slope[:-1] * slope[1:] > 0,
        2
        * slope[:-1]
        * slope[1:]
        / np.where(slope[:-1] + slope[1:] == 0, 1, slope[:-1] + slope[1:]),
        0.0,
    )
    tangent = np.concatenate([slope[:1], inner, slope[-1:]])
    k = np.clip(np.searchsorted(x, at, side="right") - 1, 0, len(x) - 2)
    t = ((at - x[k]) / h[k, 0])[:, None]
    return np.asarray(
        (2 * t**3 - 3 * t**2 + 1) * y[k]
        + (t**3 - 2 * t**2 + t) * h[k] * tangent[k]
        + (3 * t**2 - 2 * t**3) * y[k + 1]
        + (t**3 - t**2) * h[k] * tangent[k + 1]
    )


def extremes(points: Floats, directions: int = 110) -> Floats:
    """The points (m, 3) of (n, 3) that lie outermost in one of so many directions: their hull."""
    if not len(points):
        return points
    return np.asarray(points[np.unique((points @ sphere_points(directions).T).argmax(axis=0))])


def sphere_points(count: int) -> Floats:
    """Points (count, 3) spread evenly over the unit sphere, on a golden spiral."""
    index = np.arange(count) + 0.5
    z = 1.0 - 2.0 * index / count
    turn = np.pi * (1.0 + 5**0.5) * index
    flat = np.sqrt(1.0 - z * z)
    return np.column_stack([flat * np.cos(turn), flat * np.sin(turn), z])


def capped(rings: Floats) -> Floats:
    """Rings (k, s, 3) with a pole at the mean of the first and of the last: (k + 2, s, 3)."""
    first, last = (np.broadcast_to(r.mean(axis=0), r.shape) for r in (rings[0], rings[-1]))
    return np.concatenate([first[None], rings, last[None]])


def limb(
    length_m: float,
    radii_m: Floats,
    sides: int = 20,
    rings: int = 10,
    flatness: float = 1.0,
    end_rings: int = 4,
    far_cap: float = 1.0,
) -> Surface:
    """A limb along +x from 0 to length_m with round ends that reach past both.

    radii_m (k,): radii at k equally spaced stations; flatness: extent along z over that along y;
    far_cap: how far the far end bulges, in radii.
    """
    stations = np.column_stack([np.linspace(0, length_m, len(radii_m)), radii_m])
    x = np.linspace(0, length_m, rings)
    r = interpolate(stations, x)[:, 0]
    arc = np.linspace(0, np.pi / 2, end_rings + 1)[:-1]
    x = np.concatenate(
        [-radii_m[0] * np.cos(arc), x, length_m + far_cap * radii_m[-1] * np.cos(arc[::-1])]
    )
    r = np.concatenate([radii_m[0] * np.sin(arc), r, radii_m[-1] * np.sin(arc[::-1])])
    circle = superellipse(sides, 2.0)
    grid = np.empty((len(x), sides + 1, 3))
    grid[..., 0] = x[:, None]
    grid[..., 1] = r[:, None] * circle[:, 0]
    grid[..., 2] = r[:, None] * circle[:, 1] * flatness
    # Rings run along +x, sides counter-clockwise about it: ring x side points inwards.
    return closed_grid(grid[::-1])


def revolved(profile_m: Floats, sides: int = 32) -> Surface:
    """A surface of revolution about z from a profile (k, 2) of (radius, z), run from bottom outside
    upwards, and inside downwards again for a vessel. v runs down from the top, by height."""
    circle = superellipse(sides, 2.0)
    grid = np.empty((len(profile_m), sides + 1, 3))
    grid[..., 0] = profile_m[:, :1] * circle[:, 0]
    grid[..., 1] = profile_m[:, :1] * circle[:, 1]
    grid[..., 2] = profile_m[:, 1:]
    surface = closed_grid(grid[::-1])
    z = surface.vertices_m[:, 2]
    uv = np.column_stack([surface.uv[:, 0], (z.max() - z) / np.ptp(z)])
    return replace(surface, uv=uv)


def ellipsoid(half_m: Floats, sides: int = 18, rings: int = 10) -> Surface:
    """An ellipsoid about the origin by its half axes (3,)."""
    polar = np.linspace(0.0, np.pi, rings)
    circle = superellipse(sides, 2.0)
    grid = np.empty((rings, sides + 1, 3))
    grid[..., 0] = np.sin(polar)[:, None] * circle[:, 0]
    grid[..., 1] = np.sin(polar)[:, None] * circle[:, 1]
    grid[..., 2] = np.cos(polar)[:, None]
    grid[[0, -1], :, :2] = 0.0
    return closed_grid(grid * half_m)


def limb_ring(radius_m: float, thickness_m: float) -> Surface:
    """A torus about z."""
    turn = np.linspace(0, 2 * np.pi, 29)
    tube = superellipse(8, 2.0)
    grid = np.empty((len(turn), len(tube), 3))
    reach = radius_m + thickness_m * tube[:, 0]
    grid[..., 0] = np.cos(turn)[:, None] * reach
    grid[..., 1] = np.sin(turn)[:, None] * reach
    grid[..., 2] = thickness_m * tube[:, 1]
    return closed_grid(grid)
