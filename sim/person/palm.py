"""The palm of the hand: a smooth blend of round bones and muscles, meshed by rays from within."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np

from pjpdaf.arrays import Floats, readonly
from sim.surfaces.shapes import Surface, capped, closed_grid

# Round bars of the average right hand in the hand frame: both ends (x, y, z) and radii there, and
# how far the bar blends into those before it [mm].
_BARS_MM = np.array(
    [
        # the wrist, nearly round where it leaves the sleeve, and the heel of the hand
        [-97, 4.0, 0, 17.2, -78, 8.0, -0.5, 14.8, 1],
        [-97, -4.0, 0, 17.2, -78, -8.0, -0.5, 14.8, 8],
        [-78, 8.0, -0.5, 14.8, -58, 13, -1, 13.0, 8],
        [-78, -8.0, -0.5, 14.8, -56, -14, -2, 12.6, 8],
        # the bones behind the four fingers, which end in the knuckles
        [-60, 10, 1, 11.8, 23.5, 30, 0.5, 9.6, 8],
        [-60, 3, 2, 12.2, 28, 10, 2.5, 9.9, 8],
        [-60, -5, 2, 12.0, 23.5, -10.5, 1.0, 9.3, 8],
        [-58, -13, 0, 11.0, 13, -30, -2.0, 8.4, 8],
        # the balls of thumb and little finger, and the pads below the knuckles
        [-58, 13, -4, 11.0, -37, 31, -5.5, 10.4, 9],
        [-57, -15, -4, 10.5, -12, -29.5, -4.5, 9.3, 8],
        [14, 26, -5, 8.0, 4, -24, -6, 8.0, 7],
        # the web of the thumb
        [-33, 32, -4, 7.5, 2, 31, -2.5, 6.5, 14],
        # stubs below the fingers' roots: the webs between them
        [18, 30, -4, 7.6, 30, 31.0, -6.5, 6.6, 6],
        [22, 10, -2, 7.8, 34, 10.2, -6, 6.8, 6],
        [18, -10.5, -3, 7.6, 31, -11.4, -6.5, 6.6, 6],
        [8, -30, -6, 6.8, 19, -32.0, -8, 6.0, 6],
    ]
)
_FLAT = 0.45  # rays leave the axis of the hand as in an ellipse of this flatness
_COLUMNS, _ALONG, _FAN = 37, 12, 16


def palm_mesh(grid_m: Floats, uv: Floats) -> Surface:
    """The surface of a palm's grid with texture coordinates (rings, columns, 2) of its points."""
    surface = closed_grid(capped(grid_m)[::-1])
    ends = np.concatenate([uv[:1], uv, uv[-1:]])[::-1]
    return replace(surface, uv=ends.reshape(-1, 2))


def distance(points_m: Floats) -> Floats:
    """How far points (n, 3) [m] lie outside the average right palm, negative within it (n,) [m].

    Polynomial smooth minimum of the bars' distances (Quilez).
    """
    total = np.full(len(points_m), 1.0)
    for bar in _BARS_MM / 1000.0:
        start, first, end, last, blend = bar[:3], bar[3], bar[4:7], bar[7], bar[8]
        along = end - start
        share = np.clip((points_m - start) @ along / (along @ along), 0.0, 1.0)
        aside = points_m - start - share[:, None] * along
        away = np.sqrt((aside * aside).sum(axis=1)) - (first + share * (last - first))
        mixed = np.maximum(blend - np.abs(total - away), 0.0)
        total = np.minimum(total, away) - mixed * mixed / (4.0 * blend)
    return total


@lru_cache(maxsize=1)
def palm_grid() -> Floats:
    """Points (rings, columns, 3) [m] of the average right palm, from the wrist to the fingers.

    Columns run about +x from +y (the thumb's side) over +z (the back); the last repeats the first.
    """
    about = np.linspace(0.0, 2.0 * np.pi, _COLUMNS)
    # Beside the wrist and the palm rays leave the axis at right angles, before it like a fan.
    x = np.concatenate([np.linspace(-0.0954, -0.014, _ALONG), np.linspace(-0.009, 0.0, _FAN)])
    ahead = np.concatenate(
        [np.zeros(_ALONG), np.radians(90.0 * np.linspace(0.06, 0.97, _FAN) ** 0.9)]
    )
    rays = np.empty((len(x), _COLUMNS, 3))
    rays[..., 0] = np.sin(ahead)[:, None]
    rays[..., 1] = np.cos(ahead)[:, None] * np.cos(about)
    rays[..., 2] = np.cos(ahead)[:, None] * np.sin(about) * _FLAT
    rays = (rays / np.linalg.norm(rays, axis=-1, keepdims=True)).reshape(-1, 3)
    middle = np.interp(x, [-0.08, -0.04, 0.0], [0.0, 0.002, 0.0])
    origins = np.column_stack([x, middle, np.full(len(x), -0.001)])
    origins = np.repeat(origins, _COLUMNS, axis=0)
    reach = np.zeros(len(rays))
    for _ in range(30):  # within, a step of the distance never leaves the surface
        reach -= distance(origins + reach[:, None] * rays)
    grid = (origins + reach[:, None] * rays).reshape(len(x), _COLUMNS, 3)
    grid[:, -1] = grid[:, 0]
    return readonly(grid, (len(x), _COLUMNS, 3), "palm")
