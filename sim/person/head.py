"""The head: skull and face as a surface in the head frame (numpy only)."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from pjpdaf.arrays import Floats, readonly
from sim.anatomy import Anatomy
from sim.surfaces.shapes import Surface, closed_grid, extremes
from sim.surfaces.textures import soft

RINGS, SIDES = 44, 52
EYE_Y, EYE_Z = 0.0325, 0.006  # of an average head; all features scale with the head's size
_AVERAGE = (0.099, 0.0761, 0.1127)  # half depth, breadth, height [m] the features are drawn for


def head_surface(anatomy: Anatomy) -> Surface:
    """Skull and face, origin at the head's centre, x out of the face, y left, z to the crown."""
    theta, phi = angles(RINGS, SIDES + 1)
    return closed_grid(scaled(face_points(theta, phi), anatomy))


def ear_surface(anatomy: Anatomy) -> Surface:
    """An ear about its middle, hollow on the side of +y; mirror y for the other side."""
    k = anatomy.head_breadth_m / _AVERAGE[1] / 2
    turn = np.linspace(0.0, 2.0 * np.pi, 19)
    polar = np.linspace(0.0, np.pi, 12)[:, None]
    x = 0.017 * np.sin(polar) * np.cos(turn)
    z = 0.029 * np.cos(polar) + 0.0 * turn
    x = x * (1.0 + 0.25 * z / 0.029)  # narrower at the lobe
    y = 0.0065 * np.sin(polar) * np.sin(turn)
    hollow = np.exp(-(((x - 0.001) / 0.0085) ** 2) - ((z - 0.003) / 0.0165) ** 2)
    y = np.where(y > 0.0, y * (1.0 - 1.25 * hollow), y)
    return closed_grid(k * np.stack([x, y, z], axis=-1))


@lru_cache(maxsize=1)
def _average_beard() -> Floats:
    """Points about the jaw where a beard is dense; the moustache is too thin to part the face."""
    points = face_points(*angles(60, 73)).reshape(-1, 3)
    x, y, z = points.T
    dense = (z < -0.042 - 0.25 * (0.05 - np.abs(y))) & (x > 0.04)
    return readonly(extremes(points[dense]), (None, 3), "beard")


def beard_points(anatomy: Anatomy) -> Floats:
    """Points (n, 3) about the bearded part of the face, head frame."""
    return scaled(_average_beard(), anatomy)


def angles(rings: int, columns: int) -> tuple[Floats, Floats]:
    """Polar angle from the crown, azimuth from the face; denser in front, the seam at the back."""
    s = np.linspace(-1, 1, columns)
    theta, warped = np.meshgrid(
        np.linspace(0, np.pi, rings), np.pi * np.sign(s) * np.abs(s) ** 1.3, indexing="ij"
    )
    return theta, warped


def face_points(theta: Floats, phi: Floats, features: bool = True) -> Floats:
    """Points (..., 3) of the average head [m]; without features, of the smooth skull below them."""
    a, b, c = _AVERAGE
    up = np.cos(theta)
    below = np.clip(-up, 0, 1)
    # Under the cheekbones the cross-sections shrink slower than an ellipsoid's: a jaw, not an egg.
    # Above the temples as well: a skull, not a cone.
    ring = np.sin(theta) ** (1 - 0.38 * below - 0.20 * np.clip(up, 0, 1))
    front = np.clip(np.cos(phi), 0, 1) ** 1.5
    back = np.clip(-np.cos(phi), 0, 1)
    width = 1 - 0.24 * below**1.6
    depth = 1 - 0.09 * front - 0.10 * front * below - 0.42 * back * below**0.8
    square = 1 + 0.05 * np.sin(2 * phi) ** 2
    x = a * np.cos(phi) * ring * depth * square
    y = b * np.sin(phi) * ring * width * square
    z = c * up
    if features:
        side = np.abs(y)

        def bump(dy: float, dz: float, wy: float, wz: float) -> Floats:
            return np.asarray(np.exp(-(((side - dy) / wy) ** 2) - ((z - dz) / wz) ** 2))

        tip = np.clip((0.016 - z) / 0.045, 0, 1)
        nose = 0.025 * tip * soft(z + 0.034, 0.004)
        nose = nose * np.exp(-((side / (0.0065 + 0.0055 * tip)) ** 2))
        nose = nose + 0.004 * bump(0.0115, -0.029, 0.005, 0.006)
        x = x + front * (
            nose
            - 0.008 * bump(EYE_Y, EYE_Z + 0.003, 0.015, 0.010)
            + 0.0035 * bump(EYE_Y, EYE_Z, 0.010, 0.0065)
            + 0.0040 * bump(0.022, 0.027, 0.026, 0.008)
            + 0.0045 * bump(0.046, -0.014, 0.015, 0.013)
            + 0.0050 * bump(0.0, -0.053, 0.019, 0.011)
            - 0.0035 * bump(0.0, -0.068, 0.020, 0.006)
            + 0.0085 * bump(0.0, -0.090, 0.018, 0.015)
        )
    return np.stack([x, y, z], axis=-1)


def scaled(points: Floats, anatomy: Anatomy) -> Floats:
    """Points (..., 3) of the average head as those of a person's."""
    half = np.array([anatomy.head_depth_m, anatomy.head_breadth_m, anatomy.head_height_m]) / 2
    return np.asarray(points * half / np.array(_AVERAGE))
