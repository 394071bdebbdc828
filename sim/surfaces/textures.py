"""Procedural textures: plaster, wood, cloth, carpet, paintings. uint8 RGB (h, w, 3)."""

from __future__ import annotations

import itertools

import cv2
import numpy as np

from pjpdaf.arrays import Floats
from sim.specs import RGB

Texture = np.ndarray
PATTERNS = ("plain", "stripes", "checks")  # of a shirt's cloth
SURFACES = ("wood", "cloth", "plain")  # of a table
STRIPES = 18  # bands over a whole shirt: a multiple of 3, as sleeves are cut from a third of it


def value_noise(rng: np.random.Generator, shape: tuple[int, int], cells: tuple[int, int]) -> Floats:
    """Smooth noise (h, w), mean 0, standard deviation 1, about `cells` bumps along each axis."""
    coarse = rng.standard_normal((cells[0] + 1, cells[1] + 1)).astype(np.float32)
    fine = cv2.resize(coarse, shape[::-1], interpolation=cv2.INTER_CUBIC).astype(np.float64)
    return np.asarray((fine - fine.mean()) / (fine.std() + 1e-12))


def shade(rgb: RGB, luminance: Floats) -> Texture:
    """A colour times a luminance map (h, w) around 1."""
    return to_bytes(np.array(rgb) * luminance[..., None])


def to_bytes(rgb: Floats) -> Texture:
    """Linear 0-1 to uint8, clipped."""
    return np.asarray(np.clip(rgb * 255 + 0.5, 0, 255).astype(np.uint8))


def plaster(rng: np.random.Generator, rgb: RGB, size: int = 512) -> Texture:
    """A painted wall: grain, trowel marks, a faint unevenness, darker towards floor and ceiling."""
    shape = (size, size)
    grain = rng.standard_normal(shape)
    marks = value_noise(rng, shape, (170, 200))
    uneven = value_noise(rng, shape, (5, 7))
    height = np.linspace(-1, 1, size)[:, None]
    luminance = 1 + 0.014 * grain + 0.016 * marks + 0.02 * uneven - 0.06 * height**4
    return shade(rgb, luminance)


def wood(rng: np.random.Generator, rgb: RGB, planks: int = 5, size: int = 512) -> Texture:
    """Planks along the columns of the picture, with grain, rings and dark joints."""
    shape = (size, size)
    luminance = np.ones(shape)
    edges = np.linspace(0, size, planks + 1).astype(int)
    for top, bottom in itertools.pairwise(edges):
        part = (bottom - top, size)
        bend = value_noise(rng, part, (2, 4)) * 0.25
        across = np.linspace(0, 1, part[0])[:, None] + 0.06 * bend
        centre = rng.uniform(-0.2, 1.2)
        rings = np.sin(2 * np.pi * (7 * np.abs(across - centre) ** 1.3 + 0.2 * bend))
        fibre = value_noise(rng, part, (part[0] // 2, 10))
        luminance[top:bottom] = (
            1 + rng.normal(0, 0.035) + 0.030 * rings + 0.022 * fibre + 0.02 * bend
        )
        luminance[top : top + 2] *= 0.72
    return shade(rgb, luminance)


def cloth(rng: np.random.Generator, rgb: RGB, pattern: str = "plain", size: int = 256) -> Texture:
    """Woven cloth with soft wrinkles, with a pattern of PATTERNS printed on it.

    STRIPES bands along the rows, as many checks along the columns: a piece of a whole share of the
    width closes without a seam.
    """
    shape = (size, size)
    folds = value_noise(rng, shape, (10, 7))
    folds = np.tanh(folds) + 0.5 * value_noise(rng, shape, (22, 16))
    weave = rng.standard_normal(shape)
    light = 0.94 + 0.06 * folds + 0.025 * weave
    if pattern == "plain":
        return shade(rgb, light)
    turn = np.arange(size) * (2 * np.pi * STRIPES / size)
    band = soft(np.sin(turn), 0.35)
    share = np.broadcast_to(0.85 * band[:, None], shape)
    if pattern == "checks":
        share = 0.45 * (band[:, None] + soft(np.sin(turn), 0.35)[None, :])
    ground = np.array(rgb)
    print_ = second_colour(ground)
    mixed = ground + (print_ - ground) * share[..., None]
    return to_bytes(mixed * light[..., None])


def second_colour(rgb: Floats) -> Floats:
    """The ink of a printed pattern: light on dark cloth, dark on light cloth, of the same hue."""
    if rgb.max() < 0.62:
        return np.asarray(0.70 * np.array([0.93, 0.95, 1.0]) + 0.16 * rgb)
    return np.asarray(0.42 * rgb)


def tabletop(rng: np.random.Generator, rgb: RGB, surface: str, size: int = 512) -> Texture:
    """The top of a table, one of SURFACES: planks, a pressed table cloth, or laminate."""
    if surface == "wood":
        return wood(rng, rgb)
    shape = (size, size)
    if surface == "cloth":
        thread = 0.020 * (rng.standard_normal((1, size)) + rng.standard_normal((size, 1)))
        folds = 0.012 * value_noise(rng, shape, (7, 5))
        at = np.linspace(0, 1, size)
        # The creases of the cupboard: it was folded in three and in two.
        creases = np.zeros(shape)
        for place in (0.335, 0.665):
            creases += np.tanh((at - place) / 0.004)[None, :] * np.exp(
                -(((at - place) / 0.02) ** 2)
            )
        creases += (np.tanh((at - 0.5) / 0.005) * np.exp(-(((at - 0.5) / 0.025) ** 2)))[:, None]
        return shade(rgb, 1 + thread + folds + 0.06 * creases)
    specks = np.where(rng.random(shape) > 0.985, -0.05, 0.0)
    return shade(rgb, 1 + 0.010 * rng.standard_normal(shape) + specks)


def carpet(rng: np.random.Generator, rgb: RGB, size: int = 256) -> Texture:
    """A short-pile carpet."""
    shape = (size, size)
    return shade(
        rgb, 1 + 0.09 * rng.standard_normal(shape) + 0.05 * value_noise(rng, shape, (9, 9))
    )


def painting(rng: np.random.Generator, size: int = 256, warm: bool = False) -> Texture:
    """Hills under a sky, in greens and blues; warm: dunes in the evening, much like skin."""
    v = np.repeat(np.linspace(0, 1, size)[:, None], size, axis=1)
    picture = np.stack([0.45 + 0.3 * v, 0.62 + 0.2 * v, 0.80 - 0.05 * v], axis=-1)
    land, change = np.array([0.30, 0.46, 0.40]), np.array([0.0, 0.04, -0.03])
    if warm:
        picture = np.stack([0.80 + 0.08 * v, 0.60 + 0.06 * v, 0.50 - 0.02 * v], axis=-1)
        land, change = np.array([0.78, 0.54, 0.40]), np.array([0.02, 0.0, 0.0])
    clouds = np.clip(value_noise(rng, (size, size), (9, 5)), 0, 2)[..., None]
    picture = picture + 0.09 * clouds * (v < 0.5)[..., None]
    for layer in range(4):
        line = 0.42 + 0.14 * layer + 0.07 * value_noise(rng, (1, size), (1, 4 + layer))[0]
        colour = land * (1 - 0.17 * layer) + change
        rough = 1 + 0.08 * value_noise(rng, (size, size), (40, 30))[..., None]
        picture = np.where((v > line[None, :])[..., None], colour * rough, picture)
    return to_bytes(picture)


def soft(inside: Floats, width: float) -> Floats:
    """0 where `inside` is under -width, 1 above +width, smooth between."""
    t = np.clip(inside / (2 * width) + 0.5, 0, 1)
    return np.asarray(t * t * (3 - 2 * t))
