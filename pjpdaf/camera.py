"""Pinhole cameras: projection, its Jacobian, lens distortion, triangulation."""

from __future__ import annotations

from dataclasses import dataclass, field

import cv2
import numpy as np

from pjpdaf.arrays import Floats, readonly

DISTORTION_LENGTHS = (0, 4, 5, 8, 12, 14)


@dataclass(frozen=True, eq=False)
class Camera:
    """Pinhole camera with OpenCV's lens model (thesis Eq. 3.15-3.17).

    Pixel (0, 0) is the centre of the top-left pixel. Camera axes: x right, y down, z forward.

    K (3, 3) intrinsics [px]; R_cw (3, 3) world -> camera; t_cw (3,) world origin in the camera
    frame [m]; width_px, height_px picture size; distortion (n,) OpenCV's coefficients with n one of
    0, 4, 5, 8, 12, 14.
    """

    K: Floats
    R_cw: Floats
    t_cw: Floats
    width_px: int
    height_px: int
    distortion: Floats = field(default_factory=lambda: np.zeros(0))

    def __post_init__(self) -> None:
        for name, shape in {"K": (3, 3), "R_cw": (3, 3), "t_cw": (3,)}.items():
            object.__setattr__(self, name, readonly(getattr(self, name), shape, f"Camera.{name}"))
        lens = readonly(np.ravel(self.distortion), (None,), "Camera.distortion")
        if len(lens) not in DISTORTION_LENGTHS:
            raise ValueError(
                f"Camera.distortion must have one of {DISTORTION_LENGTHS} values, got {len(lens)}"
            )
        object.__setattr__(self, "distortion", lens)

    @property
    def M(self) -> Floats:  # noqa: N802 - the thesis's letter
        """Projection matrix K [R t], (3, 4) (Eq. 3.15)."""
        return np.asarray(self.K @ np.column_stack([self.R_cw, self.t_cw]))

    @property
    def centre_w(self) -> Floats:
        """Optical centre in the world, (3,) [m]."""
        return np.asarray(-self.R_cw.T @ self.t_cw)


@dataclass(frozen=True, eq=False)
class StereoRig:
    """Two cameras in one world. X_right = R X_left + T (OpenCV's stereo convention)."""

    left: Camera
    right: Camera

    @property
    def cameras(self) -> tuple[Camera, Camera]:
        """Left, right."""
        return self.left, self.right

    @property
    def R(self) -> Floats:  # noqa: N802 - OpenCV's letter
        """Rotation left camera frame -> right camera frame, (3, 3)."""
        return np.asarray(self.right.R_cw @ self.left.R_cw.T)

    @property
    def T(self) -> Floats:  # noqa: N802 - OpenCV's letter
        """Left camera's origin in the right camera frame, (3,) [m]."""
        return np.asarray(self.right.t_cw - self.R @ self.left.t_cw)


def to_camera(camera: Camera, points_w: Floats) -> Floats:
    """World points (..., 3) [m] to the camera frame (..., 3) [m]."""
    return np.asarray(points_w @ camera.R_cw.T + camera.t_cw)


def project(camera: Camera, points_w: Floats) -> Floats:
    """World points (..., 3) [m] to undistorted pixels (..., 2) (Eq. 3.15, 3.17); NaN if behind."""
    q = to_camera(camera, points_w) @ camera.K.T
    return np.asarray(q[..., :2] / np.where(q[..., 2:] > 0, q[..., 2:], np.nan))


def projection_jacobian(camera: Camera, point_w: Floats) -> Floats:
    """d project / d point at one world point (3,) [m]: (2, 3) [px/m].

    With q = M Q and s = M^3 Q: (M^{1,2} - z M^3) / s. The thesis's H (Eq. 3.20) lacks z M^3.
    """
    M = camera.M
    q = M[:, :3] @ point_w + M[:, 3]
    z = q[:2] / q[2]
    return np.asarray((M[:2, :3] - z[:, None] * M[2, :3]) / q[2])


def undistort_points(camera: Camera, pixels: Floats) -> Floats:
    """Pixels of the real picture (n, 2) to those of the ideal pinhole with the same K, (n, 2)."""
    pixels = np.asarray(pixels, dtype=np.float64).reshape(-1, 2)
    if len(pixels) == 0 or not np.any(camera.distortion):
        return pixels.copy()
    # OpenCV's default of 5 fixed-point rounds leaves up to a pixel at the corners of a wide lens.
    criteria = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 100, 1e-10)
    ideal = cv2.undistortPoints(
        pixels.reshape(-1, 1, 2),
        np.array(camera.K),
        np.array(camera.distortion),
        P=np.array(camera.K),
        criteria=criteria,
    )
    return np.asarray(ideal, dtype=np.float64).reshape(-1, 2)


def distort_points(camera: Camera, pixels: Floats) -> Floats:
    """Pixels of the ideal pinhole (n, 2) to those of the real picture, (n, 2)."""
    pixels = np.asarray(pixels, dtype=np.float64).reshape(-1, 2)
    if len(pixels) == 0 or not np.any(camera.distortion):
        return pixels.copy()
    rays = np.column_stack([pixels, np.ones(len(pixels))]) @ np.linalg.inv(camera.K).T
    real, _ = cv2.projectPoints(
        rays, np.zeros(3), np.zeros(3), np.array(camera.K), np.array(camera.distortion)
    )
    return np.asarray(real, dtype=np.float64).reshape(-1, 2)


def undistort_picture(camera: Camera, picture: np.ndarray) -> np.ndarray:
    """Resample a picture (h, w, 3) to the ideal pinhole with the same K, as in the thesis."""
    if not np.any(camera.distortion):
        return picture
    ideal: np.ndarray = cv2.undistort(picture, np.array(camera.K), np.array(camera.distortion))
    return ideal


def triangulate(cameras: tuple[Camera, ...], pixels: Floats) -> Floats:
    """Triangulate points (..., 3) [m] from their undistorted pixels (N, ..., 2) in N >= 2 views.

    Linear triangulation by SVD (Eq. 3.45). NaN where the rays are parallel (point at infinity).
    """
    rows = []
    for camera, view in zip(cameras, pixels, strict=True):
        # Rows are scaled by the focal length: the null space is taken in angles, not pixels.
        M = camera.M / np.array([[camera.K[0, 0]], [camera.K[1, 1]], [1.0]])
        x, y = view[..., 0, None], view[..., 1, None]
        rows.append(x / camera.K[0, 0] * M[2] - M[0])
        rows.append(y / camera.K[1, 1] * M[2] - M[1])
    Q = np.linalg.svd(np.stack(rows, axis=-2))[2][..., -1, :]
    scale = np.where(np.abs(Q[..., 3:]) < 1e-12, np.nan, Q[..., 3:])
    return np.asarray(Q[..., :3] / scale)
