"""Surface normals as bytes, and through a lens."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Floats, Image
from sim.camera.normal_shader import STEPS, ZERO
from sim.lens import Lens

NONE = 0  # all three bytes of a pixel without a surface


def encoded(normals: Floats) -> Image:
    """Unit normals (..., 3) as bytes."""
    return np.asarray(np.rint(STEPS * normals) + ZERO, np.uint8)


def decoded(picture: Image) -> NDArray[np.float32]:
    """Unit normals (h, w, 3) of their bytes, NaN where there is no surface."""
    normals = (picture.astype(np.float32) - ZERO) / STEPS
    length = np.linalg.norm(normals, axis=-1, keepdims=True)
    known = picture.any(axis=-1, keepdims=True) & (length > 0)
    return np.where(known, normals / np.where(known, length, 1), np.float32(np.nan))


def through_lens(
    lens: Lens, fine: Image, fine_geoms: NDArray[np.int32], geoms: NDArray[np.int32]
) -> tuple[Image, NDArray[np.bool_]]:
    """Encoded normals (h, w, 3) of the real picture, and where they are known (h, w).

    fine (h', w', 3), fine_geoms (h', w'): the ideal picture's, as OpenGL reads them; geoms (h, w):
    the real picture's. Each pixel is the mean of those around its centre that show its geom; it is
    not known where none does.
    """
    around = np.take(fine.reshape(-1, 3), lens.corners, axis=0).astype(np.float64) - ZERO
    own = np.take(fine_geoms.ravel(), lens.corners) == geoms
    mixed = (around * (lens.weights * own)[..., None]).sum(axis=0)
    length = np.linalg.norm(mixed, axis=-1, keepdims=True)
    known = length > 0
    return encoded(np.where(known, mixed / np.where(known, length, 1), 0)), known[..., 0]
