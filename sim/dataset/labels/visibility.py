"""Pixels and visibility of points inside or on the person, by the surfaces that a view shows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Floats
from pjpdaf.camera import Camera, project, to_camera
from sim.dataset.labels.records import NOT_LABELLED, OCCLUDED, VISIBLE
from sim.lens import Lens, real_pixels

# Parts are no ellipsoids: a nose and the palm's square edges reach up to this much farther, and
# so does the last bone of a finger seen along its length.
MARGIN = 1.5


@dataclass(frozen=True, eq=False)
class BodyPoints:
    """K points of the person in the world [m], each with the part of the body around it.

    points_m (K, 3); rotations (K, 3, 3): axes of the part, in the world; half_m (K, 3): half axes
    of the ellipsoid that stands for the part; shown_by (K, n) bool: whether a surface with id
    0 ... n - 1 is of the part.
    """

    points_m: Floats
    rotations: Floats
    half_m: Floats
    shown_by: NDArray[np.bool_]


def project_points(
    points: BodyPoints,
    camera: Camera,
    lens: Lens | None,
    ids: NDArray[np.integer[Any]],
    depth_m: NDArray[np.float32],
) -> tuple[Floats, NDArray[np.int8]]:
    """Real pixels (K, 2) and status (K,) of points in a view with these ids and depth (h, w).

    ids: of `BodyPoints.shown_by`; a negative one counts from the end.

    VISIBLE: the point's pixel shows a surface of its part, and that belongs to the point: it lies
    no more than MARGIN times the part's half thickness before the point, measured along the ray
    through the part's ellipsoid. So a finger before the palm of its own hand hides it, and so
    do hair and glasses.
    OCCLUDED: anything else inside the picture. NOT_LABELLED: outside it, or behind the camera.
    The pixel is NaN behind the camera and beyond the reach of the lens.
    """
    inside_c = to_camera(camera, points.points_m)
    ideal = project(camera, points.points_m).astype(np.float32)
    pixels = np.stack(real_pixels(camera, lens, ideal[:, 0], ideal[:, 1]), axis=-1).astype(float)
    height, width = depth_m.shape
    at = np.floor(pixels + 0.5)
    known = (at >= 0).all(axis=1) & (at[:, 0] < width) & (at[:, 1] < height)
    columns, rows = np.where(known, at.T, 0).astype(np.intp)
    range_m = np.linalg.norm(inside_c, axis=1)
    along_w = inside_c / range_m[:, None] @ camera.R_cw
    along = np.einsum("kji,kj->ki", points.rotations, along_w)
    half_m = 1 / np.linalg.norm(along / points.half_m, axis=1)
    planar_m = np.where(known, inside_c[:, 2], 1.0)
    before_m = range_m * (1 - depth_m[rows, columns] / planar_m)
    mine = points.shown_by[np.arange(len(at)), ids[rows, columns]]
    status = np.where(mine & (before_m <= MARGIN * half_m), VISIBLE, OCCLUDED)
    return pixels, np.where(known, status, NOT_LABELLED).astype(np.int8)
