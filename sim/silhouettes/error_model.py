"""Errors of a detector's blobs beside the painted silhouettes."""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from pjpdaf.arrays import Floats
from pjpdaf.detector.ellipses import Moments
from sim.randomness import generator

FILE = Path(__file__).with_name("error_model.json")
_MOST_BLOBS = 8  # of a view that have noise of their own


@dataclass(frozen=True)
class ErrorModel:
    """Parameters of the errors of a blob's centre, fitted by `examples/fit_error_model.py`.

    Deviations along each axis [px] of a picture 640 px wide: own_px of each view by itself,
    shared_px of both views together. Painting on a lattice has errors of its own: these are what
    the real detector has beyond them.
    """

    own_px: float
    shared_px: float


@cache
def error_model(detector: str) -> ErrorModel:
    """The fitted model of a preset's detector, of "default" for a name without one."""
    models = json.loads(FILE.read_text(encoding="utf-8"))["models"]
    return ErrorModel(**models.get(detector, models["default"]))


class BlobErrors:
    """Draws of an error model for the frames of an episode; the same in any order of frames."""

    def __init__(
        self, model: ErrorModel, frames: int, views: int, width_px: int, seed: int
    ) -> None:
        rng = generator(seed, "silhouettes/blobs")
        own = model.own_px * rng.standard_normal((frames, views, _MOST_BLOBS, 2))
        shared = model.shared_px * rng.standard_normal((frames, 1, _MOST_BLOBS, 2))
        self._moves_px: Floats = (own + shared) * (width_px / 640)

    def moves(self, frame: int, view: int) -> list[list[float]]:
        """The moves (x, y) [px] of the first blobs of a view, from the top down."""
        moves: list[list[float]] = self._moves_px[frame, view].tolist()
        return moves

    def applied(self, fit: Moments, frame: int, view: int) -> Moments:
        """The blobs of a view, from the top down, with their errors."""
        count = len(fit)
        moves = self._moves_px[frame, view]
        if count <= _MOST_BLOBS:
            return Moments(fit.centres + moves[:count], fit.covariances, fit.areas)
        moved = fit.centres.copy()
        moved[:_MOST_BLOBS] += moves
        return Moments(moved, fit.covariances, fit.areas)
