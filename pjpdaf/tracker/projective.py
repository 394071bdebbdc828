"""Projective Kalman filter, thesis 3.2-3.3, for T targets at once.

The thesis's state is (X Y Z 1 X' Y' Z' 0)^T (Eq. 3.18). Its rows 4 and 8 are constants: P_0 and Q
are 0 there, so F P F^T + Q, the gain K and every update leave them alone. They are left out here:
the state is (X Y Z X' Y' Z') [m, m/s] and the homogeneous 1 appears where a point is projected.
`homogeneous` gives the printed form; a test runs both side by side.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pjpdaf.arrays import Floats, readonly
from pjpdaf.camera import Camera
from pjpdaf.presets.parameters import Measurement, TrackerParameters

_KEPT = (0, 1, 2, 4, 5, 6)  # rows of Eq. 3.18 that are no constants
_EYE = np.eye(6)
NEAREST_M = 1e-3  # a prediction nearer to a camera's plane than this cannot be projected [m]


def homogeneous(state: Floats) -> Floats:
    """States (..., 6) as Eq. 3.18, (..., 8)."""
    full = np.zeros((*state.shape[:-1], 8))
    full[..., _KEPT] = state
    full[..., 3] = 1.0
    return full


def transition(dt_s: float) -> Floats:
    """F of Eq. 3.3, constant velocity, (6, 6)."""
    F = np.eye(6)
    F[[0, 1, 2], [3, 4, 5]] = dt_s
    return F


def process_noise(parameters: TrackerParameters, dt_s: float) -> Floats:
    """Q of Eq. 3.5, (6, 6) [m^2, m^2/s^2]; 'scaled' makes it grow with dt, equal at frame_s."""
    frames = dt_s / parameters.frame_s if parameters.process == "scaled" else 1.0
    position, velocity = parameters.process_position_m2, parameters.process_velocity_m2ps2
    return np.asarray(np.diag([position] * 3 + [velocity] * 3) * frames)


def start_covariance(parameters: TrackerParameters) -> Floats:
    """P_0 of Table 4.1, (6, 6) [m^2, m^2/s^2]."""
    position, velocity = parameters.start_position_m2, parameters.start_velocity_m2ps2
    return np.asarray(np.diag([position] * 3 + [velocity] * 3))


def predict(state: Floats, P: Floats, F: Floats, Q: Floats) -> tuple[Floats, Floats]:
    """One step ahead (Eq. 3.7-3.8, 3.35-3.36): state (T, 6), P (T, 6, 6) -> the same shapes."""
    return state @ F.T, F @ P @ F.T + Q


@dataclass(frozen=True, eq=False)
class Projection:
    """The projection matrices of N views, ready for `linearise`.

    M (N, 3, 4) [px, world in m]; origin_px (N, 2) pixel that the matrix H counts from.
    """

    M: Floats
    origin_px: Floats

    def __post_init__(self) -> None:
        object.__setattr__(self, "M", readonly(self.M, (None, 3, 4), "Projection.M"))
        origin = readonly(self.origin_px, (len(self.M), 2), "Projection.origin_px")
        object.__setattr__(self, "origin_px", origin)

    @staticmethod
    def of(cameras: tuple[Camera, ...], measurement: Measurement) -> Projection:
        """For one reading of Eq. 3.20; the principal points are the origin in 'centred'."""
        if not cameras:
            raise ValueError("a tracker needs at least one camera")
        M = np.array([camera.M for camera in cameras])
        origin = np.zeros((len(cameras), 2))
        if measurement == "centred":
            origin = np.array([camera.K[:2, 2] for camera in cameras])
            M[:, :2] -= origin[:, :, None] * M[:, 2:]
        return Projection(M, origin)


def linearise(
    projection: Projection, measurement: Measurement, points_w: Floats, third_row: bool
) -> tuple[Floats, Floats, Floats]:
    """Predicted measurements and H of every target in every view (Eq. 3.9, 3.20-3.21, 3.37).

    points_w (T, 3) [m]. Returns z (N, T, 2) [px], NaN behind the camera; H (N, T, r, 6) [px/m]
    with r = 3 if third_row else 2; s (N, T) the depth M^3 x [m].

    'thesis' and 'centred': H = lambda M, lambda = 1 / s. 'jacobian': (M^{1,2} - z M^3) / s, whose
    third row is 0.
    """
    N, T = len(projection.M), len(points_w)
    q = points_w @ projection.M[:, :, :3].transpose(0, 2, 1) + projection.M[:, None, :, 3]
    s = q[..., 2]
    ahead = s > NEAREST_M
    safe = np.where(ahead, s, np.nan)
    z = q[..., :2] / safe[..., None]
    slope = projection.M[:, None, :2, :3]
    if measurement == "jacobian":
        slope = slope - z[..., None] * projection.M[:, None, 2:, :3]
    H = np.zeros((N, T, 3 if third_row else 2, 6))
    H[:, :, :2, :3] = slope / safe[..., None, None]
    if third_row and measurement != "jacobian":
        H[:, :, 2, :3] = projection.M[:, None, 2, :3] / safe[..., None]
    return z + projection.origin_px[:, None], H, s


def innovation_covariance(H: Floats, P: Floats, R: Floats) -> Floats:
    """S = H P H^T + R (Eq. 3.14): H (..., r, 6), P (..., 6, 6), R (..., r, r)."""
    return np.asarray(H @ P @ H.swapaxes(-1, -2) + R)


def gain(P: Floats, H: Floats, S: Floats) -> Floats:
    """K = P H^T S^-1 (Eq. 3.12), (..., 6, r)."""
    return np.asarray(np.linalg.solve(S, H @ P).swapaxes(-1, -2))


def joseph(P: Floats, K: Floats, H: Floats, R: Floats) -> Floats:
    """(I - K H) P (Eq. 3.11) in Joseph's form, which stays symmetric and positive, (..., 6, 6)."""
    A = _EYE - K @ H
    return symmetric(A @ P @ A.swapaxes(-1, -2) + K @ R @ K.swapaxes(-1, -2))


def symmetric(P: Floats) -> Floats:
    """The symmetric part of (..., n, n)."""
    return np.asarray(0.5 * (P + P.swapaxes(-1, -2)))


def update(
    state: Floats, P: Floats, innovation: Floats, H: Floats, R: Floats
) -> tuple[Floats, Floats]:
    """Kalman update with known origins (Eq. 3.10-3.14).

    state (..., 6), P (..., 6, 6), innovation (..., r), H (..., r, 6), R (..., r, r).
    """
    K = gain(P, H, innovation_covariance(H, P, R))
    return state + (K @ innovation[..., None])[..., 0], joseph(P, K, H, R)
