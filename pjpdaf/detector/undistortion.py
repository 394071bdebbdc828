"""Undistortion (section 4.1): of the centres, or of the whole picture."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol, final

import cv2
import numpy as np

from pjpdaf.camera import Camera
from pjpdaf.detector.ellipses import Moments, undistort_moments

Maps = tuple[np.ndarray, np.ndarray]  # fixed-point maps for cv2.remap


class Undistortion(Protocol):
    """The stage between picture and centres at which the lens is taken out."""

    def maps(self, camera: Camera) -> Maps | None:
        """Maps that resample the picture before detection; None leaves it as it is."""
        ...

    def moments(self, camera: Camera, fit: Moments) -> Moments:
        """Ellipses in the undistorted picture, from those in the picture that was searched."""
        ...


@final
@dataclass(frozen=True)
class UndistortPoints:
    """Undistortion of the centres only: cheap and exact."""

    def maps(self, camera: Camera) -> Maps | None:
        """Return None."""
        return None

    def moments(self, camera: Camera, fit: Moments) -> Moments:
        """Return the ellipses undistorted."""
        return undistort_moments(camera, fit)


@final
@dataclass(frozen=True)
class UndistortPicture:
    """Undistortion of the whole picture, as in the thesis (Calibration Toolbox)."""

    def maps(self, camera: Camera) -> Maps | None:
        """Return maps to the ideal pinhole with the same K; None for a lens without distortion."""
        if not np.any(camera.distortion):
            return None
        K = np.array(camera.K)
        size = (camera.width_px, camera.height_px)
        x, y = cv2.initUndistortRectifyMap(
            K, np.array(camera.distortion), np.eye(3), K, size, cv2.CV_16SC2
        )
        return x, y

    def moments(self, camera: Camera, fit: Moments) -> Moments:
        """Return them as they are."""
        return fit


UNDISTORTIONS: Mapping[str, Undistortion] = {
    "points": UndistortPoints(),
    "picture": UndistortPicture(),
}
