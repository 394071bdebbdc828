"""Readings of the clutter C of Eq. 3.32, and the likelihood N that it is weighed against."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol, final

import numpy as np

from pjpdaf.arrays import Bools, Floats
from pjpdaf.camera import Camera


class ClutterReading(Protocol):
    """The unit of C, and the likelihood in the same unit."""

    def level(self, clutter: float, camera: Camera) -> float:
        """C of one view, from the parameter `clutter`."""
        ...

    def likelihood(self, d2: Floats, gated: Bools, S: Floats) -> Floats:
        """N (m, T) from squared distances d2 (m, T), gates (m, T) and S (T, r, r); 0 outside."""
        ...


@final
@dataclass(frozen=True)
class Density:
    """C false blobs per px^2 beside a Gaussian density N = exp(-d^2 / 2) / sqrt(det(2 pi S)).

    per_image: the parameter counts false blobs an image instead, and is divided by its area.
    """

    per_image: bool = False

    def level(self, clutter: float, camera: Camera) -> float:
        """Return C [px^-2]."""
        return clutter / (camera.width_px * camera.height_px) if self.per_image else clutter

    def likelihood(self, d2: Floats, gated: Bools, S: Floats) -> Floats:
        """Return the density [px^-2]."""
        return np.asarray(_bell(d2, gated) / np.sqrt(np.linalg.det(2 * math.pi * S)))


@final
@dataclass(frozen=True)
class Relative:
    """C relative to the Gaussian's peak: N = exp(-d^2 / 2), both without unit."""

    def level(self, clutter: float, camera: Camera) -> float:
        """Return C as it is [1]."""
        return clutter

    def likelihood(self, d2: Floats, gated: Bools, S: Floats) -> Floats:
        """Return the Gaussian over its peak [1]."""
        return _bell(d2, gated)


def _bell(d2: Floats, gated: Bools) -> Floats:
    return np.asarray(np.exp(-0.5 * np.where(gated, d2, np.inf)))


CLUTTER_READINGS: Mapping[str, ClutterReading] = {
    "density": Density(),
    "relative": Relative(),
    "area": Density(per_image=True),
}
