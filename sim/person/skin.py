"""Skin as textures: mottled, redder over knuckles, creased inside the hand, with nails."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np

from pjpdaf.arrays import Floats
from sim.anatomy import Anatomy
from sim.person.hand import FINGERS, PALM_SHARE, Finger, fingers
from sim.person.palm import palm_grid
from sim.specs import RGB
from sim.surfaces.textures import Texture, soft, to_bytes, value_noise

HAND_TEXELS = 384
# The red, green and blue of blood under thin skin, over the skin's own: hue stays skin's.
FLUSH = np.array([1.0, 0.925, 0.925])
NAIL, NAIL_EDGE = np.array([0.93, 0.74, 0.67]), np.array([0.94, 0.86, 0.78])
# Creases of the right palm, from side to side: (x, y) [mm], in the hand frame.
_CREASES_MM = (
    ((8, -38), (7, -28), (9, -14), (14, 2), (22, 13), (27, 20)),
    ((7, 40), (4, 28), (-4, 10), (-15, -8), (-24, -24)),
    ((7, 40), (2, 30), (-10, 17), (-26, 8), (-45, 4), (-60, 5)),
    ((-70, -24), (-71.5, 0), (-70, 24)),
    ((-75, -24), (-76.5, 0), (-75, 24)),
)


@dataclass(frozen=True, eq=False)
class HandMarks:
    """Where the hand's skin differs, 0-1 over the hand's texture (h, w).

    crease: dark lines; flushed: redder; inside: palm and inner side of the fingers; nail, and the
    edge of it.
    """

    crease: Floats
    flushed: Floats
    inside: Floats
    nail: Floats
    nail_edge: Floats


def mottled(rng: np.random.Generator, shape: tuple[int, int], skin_rgb: RGB) -> Floats:
    """Skin (h, w, 3): uneven in brightness and a little in its red."""
    h, w = shape
    light = 1.0 + 0.016 * value_noise(rng, shape, (h // 32, w // 32))
    light = light + 0.012 * value_noise(rng, shape, (h // 6, w // 6))
    red = 0.012 * value_noise(rng, shape, (h // 20, w // 20))[..., None] * (1.0 - FLUSH) / 0.075
    return np.asarray(np.array(skin_rgb) * (light[..., None] - red))


def skin_texture(rng: np.random.Generator, skin_rgb: RGB, size: int = 128) -> Texture:
    """Plain skin of arms, neck and ears."""
    return to_bytes(mottled(rng, (size, size), skin_rgb))


def hand_texture(rng: np.random.Generator, skin_rgb: RGB) -> Texture:
    """Skin of a hand, for `palm_surface` and the segments of `Finger`."""
    marks = hand_marks()
    skin = mottled(rng, marks.crease.shape, skin_rgb)
    inside = marks.inside[..., None]
    skin = skin * (1.0 + inside * (np.array([1.035, 1.0, 1.0]) - 1.0))
    skin = skin * (1.0 + marks.flushed[..., None] * (FLUSH - 1.0))
    skin = skin * (1.0 - marks.crease[..., None] * np.array([0.20, 0.24, 0.25]))
    skin = skin + 0.24 * marks.nail[..., None] * (NAIL - skin)
    return to_bytes(skin + 0.22 * marks.nail_edge[..., None] * (NAIL_EDGE - skin))


@lru_cache(maxsize=1)
def hand_marks() -> HandMarks:
    """The marks of the average hand."""
    size = HAND_TEXELS
    marks = np.zeros((5, size, size))
    wide = round(PALM_SHARE * size)
    marks[..., :wide] = _palm_marks(size, wide)
    tall = size / len(FINGERS)
    for row, finger in enumerate(fingers(Anatomy.of(1.72))):
        top, bottom = round(row * tall), round((row + 1) * tall)
        for segment in range(3):
            left, right = (round(wide + (size - wide) * (segment + k) / 3) for k in (0, 1))
            marks[:, top:bottom, left:right] = _finger_marks(
                finger, segment, bottom - top, right - left
            )
    return HandMarks(*marks)


def _texel_points(grid_m: Floats, rings: Floats, columns: Floats) -> Floats:
    """Points (len(rings), len(columns), 3) of a grid, between its rings and columns, by index."""
    x, y = np.meshgrid(columns.astype(np.float32), rings.astype(np.float32))
    return np.asarray(cv2.remap(grid_m.astype(np.float32), x, y, cv2.INTER_LINEAR), np.float64)


def _near(values: Floats, width: float) -> Floats:
    return np.asarray(np.exp(-((values / width) ** 2)))


def _to_line(x: Floats, y: Floats, line: tuple[tuple[float, float], ...]) -> Floats:
    """Distance of points to a chain of straight pieces."""
    away = np.full_like(x, np.inf)
    for (ax, ay), (bx, by) in itertools.pairwise(line):
        dx, dy = bx - ax, by - ay
        share = np.clip(((x - ax) * dx + (y - ay) * dy) / (dx * dx + dy * dy), 0.0, 1.0)
        away = np.minimum(away, np.hypot(x - ax - share * dx, y - ay - share * dy))
    return away


def _palm_marks(height: int, width: int) -> Floats:
    """The marks (5, height, width) of the palm: it lies in the texture from the wrist down."""
    grid = palm_grid()
    rings, columns = (np.array(grid.shape[:2]) - 1).tolist()
    points = 1000.0 * _texel_points(
        grid, np.linspace(0, rings, height), np.linspace(0, columns, width)
    )
    x, y, z = np.moveaxis(points, -1, 0)
    inside, back = soft(-z - 2.0, 4.0), soft(z - 2.0, 3.0)
    crease = np.zeros_like(x)
    for k, line in enumerate(_CREASES_MM):
        crease = np.maximum(crease, (0.85 if k < 3 else 0.5) * _near(_to_line(x, y, line), 1.3))
    knuckles = np.zeros_like(x)
    for finger in fingers(Anatomy.of(1.72))[1:]:
        bx, by, _ = 1000.0 * finger.base_m
        knuckles = knuckles + _near(np.hypot(x - bx + 1.0, y - by), 8.0)
        lines = np.cos((x - bx) * 1.9) ** 4 * _near(np.hypot(x - bx, y - by), 5.5)
        crease = np.maximum(crease * inside, 0.28 * lines * back)
    heel = _near(np.hypot(x + 45, y - 24), 14.0) + _near(np.hypot(x + 35, y + 28), 14.0)
    flushed = np.clip(knuckles * back + 0.6 * heel * inside, 0.0, 1.0)
    return np.stack([crease, flushed, inside, np.zeros_like(x), np.zeros_like(x)])


def _finger_marks(finger: Finger, segment: int, height: int, width: int) -> Floats:
    """The marks (5, height, width) of a segment, along its strip; see `strip_uv`."""
    grid = finger.segment_grid(segment)
    share = np.clip((np.linspace(0, 1, width) - 0.02) / 0.96, 0.0, 1.0)
    rings = grid[:, 0, 0] - grid[0, 0, 0]
    at = np.interp(share, rings / rings[-1], np.arange(len(rings)))
    around = np.clip((np.linspace(0, 1, height) - 0.02) / 0.96, 0.0, 1.0) * (grid.shape[1] - 1)
    points = 1000.0 * np.swapaxes(_texel_points(grid, at, around), 0, 1)
    x, y, z = np.moveaxis(points, -1, 0)
    length, r1 = 1000.0 * finger.lengths_m[segment], 1000.0 * finger.radii_m[segment + 1]
    inside, back = soft(-z - 1.0, 2.0), soft(z - 1.0, 2.0)
    joints = [(0.0, segment > 0 or finger.name == "thumb"), (length, segment < 2)]
    crease, flushed = np.zeros_like(x), np.zeros_like(x)
    for joint, shown in joints:
        if shown:
            wrinkles = np.cos((x - joint) * 1.45) ** 6 * _near(x - joint, 4.2)
            crease = np.maximum(crease, 0.30 * wrinkles * back)
            crease = np.maximum(crease, 0.40 * _near(x - joint, 0.7) * inside)
            flushed = np.maximum(flushed, 0.8 * _near(x - joint, 6.5) * back)
    if segment == 0 and finger.name != "thumb":  # where the finger leaves the palm
        crease = np.maximum(crease, 0.45 * _near(x - 0.46 * length, 0.8) * inside)
    nail = edge = np.zeros_like(x)
    if segment == 2:
        flushed = np.maximum(flushed, 0.7 * soft(x - length + 2.0, 3.0) * inside)
        middle, half, wide = length - 0.05 * r1, 0.88 * r1, 0.76 * r1
        level = np.abs((x - middle) / half) ** 2.6 + np.abs(y / wide) ** 2.6
        nail = soft(1.0 - level, 0.10) * (z > 0)
        edge = nail * soft(x - middle - 0.78 * half, 0.5)
        crease = np.maximum(crease, 0.55 * _near(level - 1.12, 0.16) * (z > 0))
    return np.stack([crease, flushed, inside, nail, edge])
