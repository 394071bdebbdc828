"""Errors of a detector's blobs beside the painted silhouettes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.detector.ellipses import Moments
from sim.randomness import generator

_MOST_BLOBS = 8  # of a view that have noise of their own


@dataclass(frozen=True)
class ErrorModel:
    """Parameters of the errors.

    centre_px: deviation of a blob's centre along each axis of its ellipse, as a share of the
    semi-axis, and centre_floor_px, added to it in squares.
    """

    centre_share: float = 0.0
    centre_floor_px: float = 0.1


class BlobErrors:
    """Draws of an error model for the frames of an episode; the same in any order of frames."""

    def __init__(self, model: ErrorModel, frames: int, views: int, seed: int) -> None:
        self.model = model
        rng = generator(seed, "silhouettes/blobs")
        self._normals: Floats = rng.standard_normal((frames, views, _MOST_BLOBS, 2))

    def applied(self, fit: Moments, frame: int, view: int) -> Moments:
        """The blobs of a view with their errors."""
        normals = self._normals[frame, view, np.arange(len(fit)) % _MOST_BLOBS]
        values, vectors = np.linalg.eigh(fit.covariances)
        m = self.model
        sd = np.sqrt(m.centre_floor_px**2 + (2.0 * m.centre_share) ** 2 * values)
        moved = np.einsum("kij,kj->ki", vectors, sd * normals)
        return Moments(fit.centres + moved, fit.covariances, fit.areas)
