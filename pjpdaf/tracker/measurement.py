"""Measurement models (thesis 3.3.1): from a state to pixels, and the matrix H at that state."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Protocol, final

import numpy as np

from pjpdaf.arrays import Floats, readonly
from pjpdaf.camera import Camera
from pjpdaf.checks import AboveZero, NotNegative, check_bounds

NEAREST_M = 1e-3  # a prediction nearer to a camera's plane than this cannot be projected [m]


class MeasurementModel(Protocol):
    """A reading of the measurement matrix H of Eq. 3.20."""

    def origins_px(self, cameras: tuple[Camera, ...]) -> Floats:
        """Pixel of each view that measurements count from, (N, 2)."""
        ...

    def slopes(self, M: Floats, z: Floats) -> Floats:
        """H times the depth: M (N, 3, 4), pixels z (N, T, 2) from the origin -> (N, T, 3, 3)."""
        ...


@final
@dataclass(frozen=True)
class LambdaM:
    """H = lambda M as printed, lambda = 1 / (M^3 x) (Eq. 3.20-3.21).

    centred: the pixel origin is the principal point instead of the top-left pixel.
    """

    centred: bool = False

    def origins_px(self, cameras: tuple[Camera, ...]) -> Floats:
        """Return the principal points or zeros."""
        points = np.array([camera.K[:2, 2] for camera in cameras])
        return points if self.centred else np.zeros_like(points)

    def slopes(self, M: Floats, z: Floats) -> Floats:
        """Return M's first three columns, the same at every point."""
        return np.asarray(np.broadcast_to(M[:, None, :, :3], (*z.shape[:2], 3, 3)))


@final
@dataclass(frozen=True)
class Jacobian:
    """H = (M^{1,2} - z M^3) / (M^3 x), the derivative of the projection; its third row is 0."""

    def origins_px(self, cameras: tuple[Camera, ...]) -> Floats:
        """Return zeros: the top-left pixel."""
        return np.zeros((len(cameras), 2))

    def slopes(self, M: Floats, z: Floats) -> Floats:
        """Return M - (z 1)^T M^3."""
        full = np.concatenate([z, np.ones((*z.shape[:2], 1))], axis=-1)
        return np.asarray(M[:, None, :, :3] - full[..., None] * M[:, None, 2:, :3])


MEASUREMENT_MODELS: Mapping[str, MeasurementModel] = {
    "thesis": LambdaM(),
    "centred": LambdaM(centred=True),
    "jacobian": Jacobian(),
}


@dataclass(frozen=True)
class MeasurementParameters:
    """Measurement: z = H x with noise R (Eq. 3.9, 3.19-3.23)."""

    measurement: MeasurementModel = field(default_factory=Jacobian)
    # R = diag(r r r_3) of Eq. 3.22, Table 4.1: r per axis [px^2] ...
    measurement_px2: AboveZero = 15.0
    # ... and r_3 [1], the variance of the constant third row of Eq. 3.19; 0 = no third row.
    third_row_variance: NotNegative = 0.0

    def __post_init__(self) -> None:
        check_bounds("TrackerParameters", self)

    @property
    def R(self) -> Floats:  # noqa: N802
        """Noise of a view, (2, 2) or with the third row (3, 3)."""
        variances = [self.measurement_px2, self.measurement_px2]
        return np.diag(variances + ([self.third_row_variance] if self.third_row_variance else []))


@dataclass(frozen=True, eq=False)
class Projection:
    """The projection matrices of N views, ready for `linearise`.

    M (N, 3, 4) [px, world in m]; origins_px (N, 2) pixel that the matrix H counts from.
    """

    model: MeasurementModel
    M: Floats
    origins_px: Floats

    def __post_init__(self) -> None:
        object.__setattr__(self, "M", readonly(self.M, (None, 3, 4), "Projection.M"))
        origins = readonly(self.origins_px, (len(self.M), 2), "Projection.origins_px")
        object.__setattr__(self, "origins_px", origins)

    @staticmethod
    def of(cameras: tuple[Camera, ...], model: MeasurementModel) -> Projection:
        """Return the projection of N >= 1 cameras for a reading of Eq. 3.20."""
        if not cameras:
            raise ValueError("a tracker needs at least one camera")
        M = np.array([camera.M for camera in cameras])
        origins = model.origins_px(cameras)
        if origins.any():
            M[:, :2] -= origins[:, :, None] * M[:, 2:]
        return Projection(model, M, origins)


def linearise(
    projection: Projection, points_w: Floats, third_row: bool
) -> tuple[Floats, Floats, Floats]:
    """Predicted measurements and H of every target in every view (Eq. 3.9, 3.20-3.21, 3.37).

    points_w (T, 3) [m]. Returns z (N, T, 2) [px], NaN behind the camera; H (N, T, r, 6) [px/m]
    with r = 3 if third_row else 2; s (N, T) the depth M^3 x [m].
    """
    N, T = len(projection.M), len(points_w)
    q = points_w @ projection.M[:, :, :3].transpose(0, 2, 1) + projection.M[:, None, :, 3]
    s = q[..., 2]
    safe = np.where(s > NEAREST_M, s, np.nan)
    z = q[..., :2] / safe[..., None]
    r = 3 if third_row else 2
    H = np.zeros((N, T, r, 6))
    H[..., :3] = projection.model.slopes(projection.M, z)[:, :, :r] / safe[..., None, None]
    return z + projection.origins_px[:, None], H, s
