"""Lens distortion: the real picture resampled from a wider ideal pinhole picture."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Floats
from pjpdaf.camera import Camera, undistort_points

SCALE = 2  # both pictures are sampled this much finer per axis
LARGEST = 2.0  # times the real picture's width or height


@dataclass(frozen=True, eq=False)
class Lens:
    """Where each pixel of the real picture lies in the ideal one.

    ideal: the pinhole to render, same pose and focal lengths, wide enough. colour_map
    (SCALE h, SCALE w, 2) float32: fine real pixel -> fine ideal pixel. label_index (h, w): flat
    index of the fine ideal pixel nearest to the centre of each real pixel (0.36 px away at most).
    """

    ideal: Camera
    colour_map: NDArray[np.float32]
    label_index: NDArray[np.int64]

    def colour(self, fine: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """The real picture at SCALE from the ideal one at SCALE (h, w, 3)."""
        warped: NDArray[np.uint8] = cv2.remap(fine, self.colour_map, None, cv2.INTER_LINEAR)
        return warped

    def labels(self, fine: NDArray[Any]) -> NDArray[Any]:
        """The real labels (h, w) from the ideal ones at SCALE: nearest, nothing is mixed."""
        return np.asarray(np.take(fine.ravel(), self.label_index))


def lens_of(camera: Camera) -> Lens | None:
    """The lens of a camera, None without distortion.

    Raises ValueError for one so strong that the ideal picture would be over LARGEST times as big.
    """
    if not np.any(camera.distortion):
        return None
    width, height = camera.width_px, camera.height_px
    at = ideal_pixels(camera, 1)
    low = np.floor(at.min(axis=(0, 1))) - 2
    high = np.ceil(at.max(axis=(0, 1))) + 2
    size = high - low + 1
    if not np.all(size <= LARGEST * np.array([width, height])):
        raise ValueError(
            f"lens distortion {tuple(camera.distortion.tolist())} is too strong to render: "
            f"the ideal picture would have {size[0]:.0f} x {size[1]:.0f} pixels"
        )
    K = np.array(camera.K)
    K[:2, 2] -= low
    ideal = replace(
        camera, K=K, width_px=int(size[0]), height_px=int(size[1]), distortion=np.zeros(0)
    )
    fine = (ideal_pixels(camera, SCALE) - low + 0.5) * SCALE - 0.5
    nearest = np.rint((at - low + 0.5) * SCALE - 0.5).astype(np.int64)
    index = nearest[..., 1] * (SCALE * ideal.width_px) + nearest[..., 0]
    return Lens(ideal, fine.astype(np.float32), index)


def ideal_pixels(camera: Camera, scale: int) -> Floats:
    """Ideal pixel (scale h, scale w, 2) of each real pixel at `scale` per axis, in real pixels."""
    y, x = np.mgrid[: camera.height_px * scale, : camera.width_px * scale]
    real = (np.stack([x, y], axis=-1) + 0.5) / scale - 0.5
    return undistort_points(camera, real.reshape(-1, 2)).reshape(real.shape)
