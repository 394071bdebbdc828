"""Equations of the projective Kalman filter, thesis 3.2-3.3, for T targets at once.

The thesis's state is (X Y Z 1 X' Y' Z' 0)^T (Eq. 3.18). Its rows 4 and 8 are constants: P_0 and Q
are 0 there, so F P F^T + Q, the gain K and every update leave them alone. They are left out here:
the state is (X Y Z X' Y' Z') [m, m/s] and the homogeneous 1 appears where a point is projected.
`homogeneous` gives the printed form; a test runs both side by side.
"""

from __future__ import annotations

import numpy as np

from pjpdaf.arrays import Floats

_KEPT = (0, 1, 2, 4, 5, 6)  # rows of Eq. 3.18 that are no constants
_EYE = np.eye(6)
VARIANCE_MAX = 1e6  # [m^2, (m/s)^2]: a kilometre; such a target is lost long before


def homogeneous(state: Floats) -> Floats:
    """States (..., 6) as Eq. 3.18, (..., 8)."""
    full = np.zeros((*state.shape[:-1], 8))
    full[..., _KEPT] = state
    full[..., 3] = 1.0
    return full


def predict(state: Floats, P: Floats, F: Floats, Q: Floats) -> tuple[Floats, Floats]:
    """Predict a step (Eq. 3.7-3.8, 3.35-3.36): state (T, 6), P (T, 6, 6) -> the same shapes."""
    return state @ F.T, F @ P @ F.T + Q


def innovation_covariance(H: Floats, P: Floats, R: Floats) -> Floats:
    """S = H P H^T + R (Eq. 3.14): H (..., r, 6), P (..., 6, 6), R (..., r, r)."""
    return np.asarray(H @ P @ H.swapaxes(-1, -2) + R)


def gain(P: Floats, H: Floats, S: Floats) -> Floats:
    """K = P H^T S^-1 (Eq. 3.12), (..., 6, r); with the pseudo-inverse where S is singular."""
    try:
        return np.asarray(np.linalg.solve(S, H @ P).swapaxes(-1, -2))
    except np.linalg.LinAlgError:
        return np.asarray(P @ H.swapaxes(-1, -2) @ np.linalg.pinv(S, hermitian=True))


def inverse(S: Floats) -> Floats:
    """S^-1 (..., r, r); the pseudo-inverse where S is singular."""
    try:
        return np.asarray(np.linalg.inv(S), dtype=np.float64)
    except np.linalg.LinAlgError:
        return np.asarray(np.linalg.pinv(S, hermitian=True))


def bounded(P: Floats) -> Floats:
    """Covariances (T, 6, 6), scaled down where a variance exceeds `VARIANCE_MAX`.

    The printed sum of Eq. 3.42 doubles P at each frame without detections: after 14 s at 3 Hz it
    outweighs R by more digits than a number has, and S is singular.
    """
    largest = P.diagonal(axis1=1, axis2=2).max(axis=1)
    if not largest.max() > VARIANCE_MAX:
        return P
    return np.asarray(P * np.minimum(1.0, VARIANCE_MAX / largest)[:, None, None])


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
