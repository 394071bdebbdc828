"""Hair in several cuts: where it grows, how thick it is, and its strands (numpy only)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from pjpdaf.arrays import Floats, readonly
from sim.anatomy import Anatomy
from sim.person.head import angles, face_points, scaled
from sim.specs import Appearance
from sim.surfaces.shapes import (
    Surface,
    capped,
    closed_grid,
    ellipsoid,
    extremes,
    interpolate,
    sphere_points,
)
from sim.surfaces.textures import Texture, to_bytes, value_noise


@dataclass(frozen=True)
class Cut:
    """A cut of hair on the average head.

    top_m, side_m: how thick on the crown and above the ears; front_m: at the forehead's edge;
    raised_m: of the hairline above the usual one, at the forehead's middle and at the temples;
    curl_m: height of its curls; combed: the way its strands run, from the crown "down", "back" or
    "aside" from a parting.
    """

    top_m: float
    side_m: float
    front_m: float
    raised_m: tuple[float, float] = (0.0, 0.0)
    curl_m: float = 0.0
    combed: str = "down"


CUTS: Mapping[str, Cut] = {
    "short": Cut(0.016, 0.010, 0.009),
    "long": Cut(0.014, 0.009, 0.007),
    "curly": Cut(0.034, 0.030, 0.020, curl_m=0.008),
    "bun": Cut(0.009, 0.006, 0.004, (0.004, 0.006), combed="back"),
    "parted": Cut(0.019, 0.012, 0.012, combed="aside"),
    "receding": Cut(0.010, 0.007, 0.003, (0.008, 0.028)),
}
HAIR = ("short", "long", "bald", "curly", "bun", "parted", "receding")
_PART_Y_M = 0.030  # of the parting, on the person's left
_BUN_M, _BUN_HALF_M = np.array([-0.085, 0.0, 0.088]), np.array([0.036, 0.040, 0.034])
_RINGS, _COLUMNS, _CURLS = 26, 49, 190


def hairline(x: Floats, y: Floats, hair: str) -> Floats:
    """Height above which the hair of a cut grows on the average head [m]."""
    cut = CUTS[hair]
    knots = np.array([-0.105, -0.05, -0.022, -0.008, 0.016, 0.030, 0.055, 0.080, 0.105])
    line = np.interp(x, knots, [-0.070, -0.060, -0.028, 0.018, 0.006, 0.030, 0.062, 0.074, 0.077])
    middle, temples = cut.raised_m
    aside = np.exp(-(((np.abs(y) - 0.040) / 0.018) ** 2))
    front = np.clip((x - 0.030) / 0.03, 0.0, 1.0)
    line = line + front * (middle + (temples + 0.004 - middle) * aside)
    return np.asarray(line + 0.0010 * np.sin(410 * y + 3) + 0.0010 * np.sin(170 * y))


def hair_surface(anatomy: Anatomy, hair: str) -> Surface:
    """A cap of hair from the crown to the hairline, thin at its rim."""
    return _textured(scaled(np.array(_average_cap(hair)), anatomy), CUTS[hair].combed)


def bun_surface(anatomy: Anatomy) -> Surface:
    """The knot of hair of a bun, in the head frame."""
    bun = ellipsoid(_BUN_HALF_M, sides=22, rings=14)
    swirl = 1.0 + 0.03 * np.sin(9 * np.arctan2(bun.vertices_m[:, 2], bun.vertices_m[:, 1]))
    points = scaled(bun.vertices_m * swirl[:, None] + _BUN_M, anatomy)
    return Surface(points, bun.normals, bun.uv[:, ::-1].copy(), bun.faces)


def _textured(grid_m: Floats, combed: str) -> Surface:
    """The surface of a cap's grid; strands run down it, or as they are combed."""
    surface = closed_grid(grid_m)
    x, y, z = surface.vertices_m.T
    if combed == "back":
        uv = np.column_stack([y / 0.17 + 0.5, z / 0.3 + 0.5])
    elif combed == "aside":
        uv = np.column_stack([x / 0.22 + 0.5 - z / 0.5, np.abs(y - _PART_Y_M) / 0.2])
    else:
        return surface
    return replace(surface, uv=uv)


@lru_cache(maxsize=8)
def _average_cap(hair: str) -> Floats:
    """Points (rings, columns, 3) of a cap on the average head, outside to the rim and back in."""
    cut = CUTS[hair]
    _, phi = angles(2, _COLUMNS)
    phi = phi[0]
    # Down each meridian: where it crosses the hairline.
    theta = np.linspace(0.05, 2.6, 500)
    polar, turn = np.meshgrid(theta, phi, indexing="ij")
    down = face_points(polar, turn, features=False)
    below = down[..., 2] < hairline(down[..., 0], down[..., 1], hair)
    rim = theta[np.argmax(below, axis=0)]
    share = np.linspace(0.0, 1.0, _RINGS) ** 0.85
    skull = face_points(share[:, None] * rim, np.broadcast_to(phi, (_RINGS, _COLUMNS)), False)
    out = skull / np.linalg.norm(skull, axis=-1, keepdims=True)
    x, y, z = np.moveaxis(skull, -1, 0)
    lift = cut.side_m + (cut.top_m - cut.side_m) * np.clip(z / 0.095, 0.0, 1.0) ** 1.5
    front = np.clip((x - 0.035) / 0.045, 0.0, 1.0)
    lift = lift + (cut.front_m - lift) * front * share[:, None] ** 3
    edge = np.clip((1.0 - share[:, None]) / 0.16, 0.0, 1.0)
    lift = lift * np.sqrt(np.clip(edge * (2.0 - edge), 0.0, 1.0)) - 0.0025 * (edge == 0.0)
    if cut.combed == "aside":
        ahead = np.clip((x + 0.03) / 0.06, 0.0, 1.0) * (z > 0.03)
        lift = lift - 0.011 * ahead * np.exp(-(((y - _PART_Y_M) / 0.006) ** 2)) * edge
        lift = lift + 0.006 * ahead * np.exp(-(((y + 0.012) / 0.03) ** 2)) * edge
    elif cut.curl_m == 0.0:
        strands = np.sin(37 * phi + 5 * np.sin(3 * phi)) + 0.7 * np.sin(61 * phi + 1.0)
        lift = lift + 0.0008 * strands * share[:, None] * edge
    else:
        curls = sphere_points(_CURLS)
        nearest = (out.reshape(-1, 3) @ curls.T).max(axis=1).reshape(out.shape[:2])
        lift = lift + cut.curl_m * edge * (np.exp((nearest - 1.0) / 0.008) - 0.5)
    outside = skull + out * lift[..., None]
    outside[0] = outside[0].mean(axis=0)
    inside = skull[[-1, -4]] - np.array([0.006, 0.016])[:, None, None] * out[[-1, -4]]
    grid = np.concatenate(
        [outside, inside, np.broadcast_to(inside[-1].mean(axis=0), (1, *phi.shape, 3))]
    )
    grid[:, -1] = grid[:, 0]
    return readonly(grid, (None, _COLUMNS, 3), "hair")


# Long hair: height, half depth and half breadth outside, thickness, azimuth at which it begins.
_CURTAIN = np.array(
    [
        [-0.135, 0.098, 0.091, 0.010, 0.92],
        [-0.110, 0.108, 0.097, 0.020, 0.98],
        [-0.060, 0.114, 0.095, 0.023, 1.10],
        [0.000, 0.114, 0.090, 0.022, 1.25],
        [0.040, 0.108, 0.086, 0.018, 1.32],
        [0.080, 0.089, 0.068, 0.014, 1.45],
    ]
)


def curtain_surface(anatomy: Anatomy) -> Surface:
    """Long hair: it falls from the temples and the back of the head to the collar."""
    z = np.linspace(0.078, -0.132, 17)
    depth, breadth, thickness, begin = interpolate(_CURTAIN, z).T[..., None]
    there = np.linspace(0, 1, 46)
    turn = begin + (2 * np.pi - 2 * begin) * there
    # Strands, fuller towards the ends; the rims are drawn in, so that they are round.
    strands = 1 + 0.010 * np.sin(31 * turn) * np.clip((0.06 - z) / 0.15, 0, 1)[:, None]
    strands = strands + 0.006 * np.sin(53 * turn + 2) * np.clip((0.06 - z) / 0.1, 0, 1)[:, None]
    rim = 1 - 0.10 * np.exp(-there / 0.02) - 0.10 * np.exp(-(1 - there) / 0.02)
    outside = np.stack([depth * np.cos(turn), breadth * np.sin(turn)], axis=-1)
    outside = outside * (strands * rim)[..., None]
    inside = outside * (1 - thickness / np.hypot(depth, breadth) * 1.35)[..., None]
    outline = np.concatenate([outside, inside[:, ::-1], outside[:, :1]], axis=1)
    ends = z[:, None] + 0.0
    lowest = np.clip((-0.06 - z) / 0.07, 0, 1)[:, None]
    around = np.concatenate([turn, turn[:, ::-1], turn[:, :1]], axis=1)
    grid = np.dstack([outline, ends + 0.005 * lowest * np.sin(13 * around)])
    return closed_grid(scaled(capped(grid), anatomy))


@lru_cache(maxsize=8)
def _average_outline(hair: str) -> tuple[Floats, Floats]:
    theta, phi = angles(60, 73)
    points = face_points(theta, phi).reshape(-1, 3)
    x, y, z = points.T
    if hair == "bald":
        none = readonly(np.empty((0, 3)), (None, 3), "hair")
        return readonly(extremes(points), (None, 3), "bare"), none
    plain = face_points(theta, phi, features=False).reshape(-1, 3)
    # The nape is behind jaw and collar.
    bare = (plain[:, 2] < hairline(plain[:, 0], plain[:, 1], hair)) & (x > -0.03)
    covered = _average_cap(hair)[:_RINGS].reshape(-1, 3)
    if hair == "long":
        bare &= np.abs(np.arctan2(y, x)) < np.interp(z, _CURTAIN[:, 0], _CURTAIN[:, 4])
        falls = _CURTAIN[:, :3]
        turn = np.linspace(1.2, 2 * np.pi - 1.2, 12)
        ring = np.stack(
            [
                falls[:, 1:2] * np.cos(turn),
                falls[:, 2:3] * np.sin(turn),
                np.broadcast_to(falls[:, :1], (len(falls), len(turn))),
            ],
            axis=-1,
        )
        covered = np.concatenate([covered, ring.reshape(-1, 3)])
    if hair == "bun":
        covered = np.concatenate([covered, ellipsoid(_BUN_HALF_M).vertices_m + _BUN_M])
    return (
        readonly(extremes(points[bare]), (None, 3), "bare"),
        readonly(extremes(covered), (None, 3), "hair"),
    )


def outline_points(anatomy: Anatomy, hair: str) -> tuple[Floats, Floats]:
    """Points (n, 3) on the bare face, and (m, 3) on the hair, head frame; none of a bald head."""
    bare, covered = _average_outline(hair)
    return scaled(bare, anatomy), scaled(covered, anatomy)


def hair_texture(rng: np.random.Generator, appearance: Appearance, size: int = 256) -> Texture:
    """Strands along the rows; curls of a curly cut."""
    shape = (size, size)
    if CUTS[appearance.hair].curl_m > 0.0:
        curls = value_noise(rng, shape, (40, 56))
        luminance = 1.0 + 0.30 * np.tanh(curls) + 0.12 * value_noise(rng, shape, (110, 130))
    else:
        strands = value_noise(rng, shape, (4, size // 2))
        locks = value_noise(rng, shape, (3, size // 9))
        luminance = 1.0 + 0.20 * strands + 0.12 * locks + 0.08 * value_noise(rng, shape, (6, 24))
    return to_bytes(np.array(appearance.hair_rgb) * np.clip(luminance, 0.3, 1.9)[..., None])
