"""Vectors and rotations of single points, faster than numpy's general functions."""

from __future__ import annotations

import math

import numpy as np

from pjpdaf.arrays import Floats

# A single vector as plain numbers, which takes a third of the time of an array of three.
Vector = list[float]


def dot_of(a: Vector, b: Vector) -> float:
    """Scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def length_of(a: Vector) -> float:
    """Length."""
    return math.sqrt(dot_of(a, a))


def cross_of(a: Vector, b: Vector) -> Vector:
    """a x b."""
    (a0, a1, a2), (b0, b1, b2) = a, b
    return [a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0]


def cross(a: Floats, b: Floats) -> Floats:
    """a x b for (3,) arrays; ten times faster than `numpy.cross` for a single pair."""
    return np.array(cross_of(a.tolist(), b.tolist()))


def dots(a: Floats, b: Floats) -> Floats:
    """Scalar products (...) of arrays (..., 3); to the bit as `(a * b).sum(axis=-1)`, which takes
    five times as long over an axis of three.
    """
    product = a * b
    return np.asarray(product[..., 0] + product[..., 1] + product[..., 2])


def norm(a: Floats) -> float:
    """Length of a (3,) array."""
    return length_of(a.tolist())


def about_x(angle_rad: float) -> Floats:
    """Rotation (3, 3) about x."""
    c, s = math.cos(angle_rad), math.sin(angle_rad)
    return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])


def about_y(angle_rad: float) -> Floats:
    """Rotation (3, 3) about y; positive turns x down (-z) and z forward (+x)."""
    c, s = math.cos(angle_rad), math.sin(angle_rad)
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])


def about_z(angle_rad: float) -> Floats:
    """Rotation (3, 3) about z; positive turns x to the person's left (+y)."""
    c, s = math.cos(angle_rad), math.sin(angle_rad)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def about(axis: Floats, angle_rad: float) -> Floats:
    """Rotation (3, 3) by angle_rad about a unit axis (3,) (Rodrigues)."""
    x, y, z = axis.tolist()
    c, s = math.cos(angle_rad), math.sin(angle_rad)
    v = 1.0 - c
    return np.array(
        [
            [c + x * x * v, x * y * v - z * s, x * z * v + y * s],
            [y * x * v + z * s, c + y * y * v, y * z * v - x * s],
            [z * x * v - y * s, z * y * v + x * s, c + z * z * v],
        ]
    )


def bone_frame(start_m: Floats, end_m: Floats) -> Floats:
    """Rotation (3, 3) with +x from start to end and z as far up as x lets it."""
    x = (end_m - start_m) / norm(end_m - start_m)
    # Level, so that z is as far up as can be; exact for bones that are nearly upright.
    flat = math.hypot(x[0], x[1])
    y = np.array([-x[1], x[0], 0.0]) / flat if flat >= 1e-6 else np.array([0.0, 1.0, 0.0])
    y = y - (y @ x) * x
    y = y / norm(y)
    return np.column_stack([x, y, cross(x, y)])
