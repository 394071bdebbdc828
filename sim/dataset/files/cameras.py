"""A camera as the plain numbers of rig.json, and back."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from pjpdaf.camera import Camera

ORTHONORMAL = 1e-6  # how far R Rᵀ of a camera may be from the identity


def camera_record(camera: Camera) -> dict[str, Any]:
    """The plain numbers of a camera."""
    return {
        "K": camera.K.tolist(),
        "R_cw": camera.R_cw.tolist(),
        "t_cw": camera.t_cw.tolist(),
        "distortion": camera.distortion.tolist(),
        "width_px": camera.width_px,
        "height_px": camera.height_px,
    }


def camera_of(record: Mapping[str, Any]) -> Camera:
    """The camera of plain numbers. Raises KeyError, TypeError or ValueError."""
    width, height = int(record["width_px"]), int(record["height_px"])
    if not (0 < width <= 20_000 and 0 < height <= 20_000):
        raise ValueError("width_px and height_px must be 1 to 20000")
    numbers = {
        name: np.array(record[name], np.float64) for name in ("K", "R_cw", "t_cw", "distortion")
    }
    if not all(np.isfinite(value).all() for value in numbers.values()):
        raise ValueError("the numbers of a camera must be finite")
    camera = Camera(width_px=width, height_px=height, **numbers)
    fx, fy = np.diag(camera.K)[:2]
    if not (fx > 0 and fy > 0 and np.array_equal(camera.K[2], [0.0, 0.0, 1.0])):
        raise ValueError("K must have focal lengths above 0 and the last row 0 0 1")
    R = camera.R_cw
    if np.abs(R @ R.T - np.eye(3)).max() > ORTHONORMAL or np.linalg.det(R) < 0:
        raise ValueError("R_cw must be a rotation")
    return camera
