"""Landmarks of the drawn face: points of its surface by their names."""

from __future__ import annotations

import numpy as np

from pjpdaf.arrays import Floats
from sim.anatomy import Anatomy
from sim.person.head import EYE_Y, EYE_Z, head_surface, scaled
from sim.surfaces.shapes import Surface


def nose_and_eyes(anatomy: Anatomy) -> Floats:
    """Tip of the nose, left and right eye (3, 3) in the head frame [m], on the drawn face.

    The tip is the foremost vertex of the mid-line; an eye is the middle of its painted almond.
    """
    face = head_surface(anatomy)
    middle = face.vertices_m[np.abs(face.vertices_m[:, 1]) < 1e-9]
    _, y, z = scaled(np.array([0.0, EYE_Y, EYE_Z]), anatomy).tolist()
    eyes = [np.array([_foremost(face, side * y, z), side * y, z]) for side in (1.0, -1.0)]
    return np.array([middle[np.argmax(middle[:, 0])], *eyes])


def _foremost(surface: Surface, y: float, z: float) -> float:
    """The greatest x [m] at which a surface's triangles meet the line of these y and z."""
    a, b, c = np.moveaxis(surface.vertices_m[surface.faces], 1, 0)
    ab, ac, p = (b - a)[:, 1:], (c - a)[:, 1:], np.array([y, z]) - a[:, 1:]
    area = ab[:, 0] * ac[:, 1] - ab[:, 1] * ac[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        u = (p[:, 0] * ac[:, 1] - p[:, 1] * ac[:, 0]) / area
        v = (ab[:, 0] * p[:, 1] - ab[:, 1] * p[:, 0]) / area
    met = (u >= -1e-9) & (v >= -1e-9) & (u + v <= 1 + 1e-9)
    x = a[met, 0] + u[met] * (b - a)[met, 0] + v[met] * (c - a)[met, 0]
    return float(x.max())
