"""A surface clothed with the shirt's texture."""

from __future__ import annotations

import numpy as np

from sim.surfaces.shapes import Surface

SHIRT_M = 0.64  # length of the shirt, which its texture spans once
SLEEVE_SHARE = 1 / 3  # of the shirt's width, that goes round a sleeve or the collar


def tailored(surface: Surface, axis: int, share: float = SLEEVE_SHARE) -> Surface:
    """The surface clothed: the shirt's texture runs along an axis of the part at its true scale.

    share: of the shirt's width that goes round the part.
    """
    along = -surface.vertices_m[:, axis] / SHIRT_M
    uv = np.column_stack([surface.uv[:, 0] * share, along - along.min()])
    return Surface(surface.vertices_m, surface.normals, uv, surface.faces)
