"""The elbow as drawn: both bones' frames turned into the plane of the bend, and cloth round it."""

from __future__ import annotations

import numpy as np

from pjpdaf.arrays import Floats
from sim.person.cloth import SHIRT_M, SLEEVE_SHARE
from sim.surfaces.shapes import Surface
from sim.vectors import cross, norm

_STRAIGHT = 0.02  # sine of the bend, below which the plane of the bend says nothing


def hinged(upper: Floats, fore: Floats) -> tuple[Floats, Floats]:
    """Frames (3, 3) of upper arm and forearm, each rolled about its bone until y is the hinge.

    What is drawn on them then runs on from one to the other: +z is the outside of the bend. A
    straight arm keeps its frames.
    """
    hinge = cross(upper[:, 0], fore[:, 0])
    size = norm(hinge)
    if size < _STRAIGHT:
        return upper, fore
    y = hinge / size
    return _along(upper[:, 0], y), _along(fore[:, 0], y)


def _along(x: Floats, y: Floats) -> Floats:
    return np.column_stack([x, y, cross(x, y)])


def sleeve_above(surface: Surface, length_m: float) -> Surface:
    """A sleeve along +x that ends at an elbow at length_m, clothed with the shirt's texture."""
    return _clothed(surface, length_m - surface.vertices_m[:, 0], surface.uv[:, 0])


def sleeve_below(surface: Surface, radius_m: float) -> Surface:
    """A sleeve along +x from an elbow at 0 with a round end, clothed as `sleeve_above`.

    On the round end, of radius_m, the cloth turns about the hinge: its weft lies in planes through
    the hinge, so that stripes are parallel to those of both bones however far the elbow is bent.
    """
    x, y, z = surface.vertices_m.T
    end = x < 0.0
    turned = np.arctan2(-x, np.abs(z))
    beside = np.arccos(np.clip(y / radius_m, -1.0, 1.0)) / (2.0 * np.pi)
    along = np.where(end, radius_m * turned, -x)
    return _clothed(surface, along, np.where(end, beside, surface.uv[:, 0]))


def _clothed(surface: Surface, along_m: Floats, around: Floats) -> Surface:
    uv = np.column_stack([around * SLEEVE_SHARE, 1.0 + along_m / SHIRT_M])
    return Surface(surface.vertices_m, surface.normals, uv, surface.faces)
