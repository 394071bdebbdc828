"""Rotation between the two cameras that a calibration missed, from points of the background.

A camera that was bumped by half a degree about y moves disparities by 5 px, 0.15 m of depth at a
table, and three blobs hardly show it. Some hundred points of the whole background do: turned about
x the second picture moves up, about z it turns, about y its corners move up by x y / f.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.camera import Camera, undistort_points

FEATURES = 1500  # per picture, at most
RATIO = 0.75  # of the distances of the best and the next match (Lowe 2004)
FARTHEST_PX = 16.0  # from the epipolar line, at 640 columns: 1.5 degrees
POINTS_MIN = 40  # fewer matches say nothing
SPREAD_MIN = 0.12  # deviation of the matches over the picture's width and height
ROUNDS = 12
HUBER_PX = 0.7  # residuals above count linearly
PRIOR_DEG = 1.0  # deviation of a rotation that a calibration missed
MORE = 2.0  # errors of neighbouring matches go together
COMMON_DEG = 0.03  # deviation that lens and focal length leave, however many matches
SIGNIFICANT = 4.0  # deviations from none
LEAST_DEG = 0.12  # smaller ones are left alone
MOST_DEG = 2.5  # larger ones are no bump, but wrong matches


@dataclass(frozen=True, eq=False)
class Alignment:
    """Rotation of the second camera, about its own axes [rad] (3,), beside its calibration.

    deviations (3,) [rad]; points: matches used.
    """

    rotation: Floats
    deviations: Floats
    points: int

    @property
    def matters(self) -> bool:
        """Whether the rotation is sure, and large enough to be taken out."""
        size = math.degrees(float(np.linalg.norm(self.rotation)))
        sure = (np.abs(self.rotation) > SIGNIFICANT * self.deviations).any()
        return bool(sure and LEAST_DEG <= size <= MOST_DEG)

    def homography(self, camera: Camera) -> Floats:
        """Map (3, 3) of undistorted pixels of the second camera to those of its calibration."""
        R, _ = cv2.Rodrigues(self.rotation)
        return np.asarray(camera.K @ R @ np.linalg.inv(camera.K))


def moved(points_px: Floats, homography: Floats) -> Floats:
    """Map pixels (n, 2)."""
    if not len(points_px):
        return points_px
    q = np.concatenate([points_px, np.ones((len(points_px), 1))], axis=1) @ homography.T
    return np.asarray(q[:, :2] / q[:, 2:])


def align(
    pictures: tuple[np.ndarray, np.ndarray], cameras: tuple[Camera, Camera]
) -> Alignment | None:
    """Estimate the rotation from a still scene, uint8 BGR (h, w, 3) of each view.

    None where the scene has too few points that both views show, or they cover too little of it.
    """
    one, two = _matches(pictures)
    if len(one) < POINTS_MIN:
        return None
    return align_points(
        undistort_points(cameras[0], one), undistort_points(cameras[1], two), cameras
    )


def align_points(
    one_px: Floats, two_px: Floats, cameras: tuple[Camera, Camera]
) -> Alignment | None:
    """Estimate the rotation from undistorted pixels (n, 2) of the same points in both views."""
    limit = FARTHEST_PX * cameras[0].width_px / 640.0
    lines = _Epipolar(one_px, two_px, cameras)
    near = np.abs(lines.residuals(np.zeros(3))) < limit
    lines = lines.chosen(near)
    size = np.array([cameras[1].width_px, cameras[1].height_px])
    if near.sum() < POINTS_MIN or (two_px[near].std(axis=0) < SPREAD_MIN * size).any():
        return None
    w = np.zeros(3)
    prior = np.eye(3) / math.radians(PRIOR_DEG) ** 2
    scale = limit / 4
    for _ in range(ROUNDS):
        r, J = lines.residuals(w), lines.jacobian(w)
        scale = max(0.5 * scale, HUBER_PX)
        weight = 1.0 / np.maximum(np.abs(r) / scale, 1.0) ** 2  # wrong matches count for nothing
        A = (J * weight[:, None]).T @ J + prior
        w = w - np.linalg.solve(A, (J * weight[:, None]).T @ r + prior @ w)
    good = np.abs(r) < 4.0 * HUBER_PX
    if good.sum() < POINTS_MIN:
        return None
    sd_px = max(1.4826 * float(np.median(np.abs(r[good]))), 0.1)
    information = (J[good].T @ J[good]) / sd_px**2 + prior
    own = MORE * np.sqrt(np.diag(np.linalg.inv(information)))
    return Alignment(w, np.hypot(own, math.radians(COMMON_DEG)), int(good.sum()))


class _Epipolar:
    """Distances of points from the epipolar lines of their partners."""

    def __init__(self, one_px: Floats, two_px: Floats, cameras: tuple[Camera, Camera]) -> None:
        self._args = one_px, two_px, cameras
        one, two = cameras
        R = two.R_cw @ one.R_cw.T
        t = two.t_cw - R @ one.t_cw
        self._focal_px = float(two.K[0, 0] * two.K[1, 1]) ** 0.5
        planes = np.cross(t, _rays(one, one_px) @ R.T)  # normals of the epipolar planes
        self._planes = planes / np.linalg.norm(planes, axis=1, keepdims=True)
        self._rays = _rays(two, two_px)

    def chosen(self, which: np.ndarray) -> _Epipolar:
        one, two, cameras = self._args
        return _Epipolar(one[which], two[which], cameras)

    def residuals(self, w: Floats) -> Floats:
        """Distances (n,) [px] where the second camera is turned by w (3,) [rad]."""
        R, _ = cv2.Rodrigues(w)
        turned = self._rays @ R.T
        return np.asarray(self._focal_px * (self._planes * turned).sum(axis=1) / turned[:, 2])

    def jacobian(self, w: Floats) -> Floats:
        """Derivatives (n, 3) [px/rad]."""
        step = 1e-5
        columns = [
            (self.residuals(w + step * axis) - self.residuals(w - step * axis)) / (2 * step)
            for axis in np.eye(3)
        ]
        return np.stack(columns, axis=1)


def _rays(camera: Camera, pixels: Floats) -> Floats:
    homogeneous = np.concatenate([pixels, np.ones((len(pixels), 1))], axis=1)
    return np.asarray(homogeneous @ np.linalg.inv(camera.K).T)


def _matches(pictures: tuple[np.ndarray, np.ndarray]) -> tuple[Floats, Floats]:
    """Pixels (n, 2) of the points that both pictures show, each the other's best match."""
    sift = cv2.SIFT.create(FEATURES, contrastThreshold=0.01)
    found = [sift.detectAndCompute(cv2.cvtColor(p, cv2.COLOR_BGR2GRAY), None) for p in pictures]
    (points, one), (others, two) = found
    nothing = np.zeros((0, 2)), np.zeros((0, 2))
    if one is None or two is None or len(one) < 2 or len(two) < 2:
        return nothing
    matcher = cv2.BFMatcher(cv2.NORM_L2)
    there, back = matcher.knnMatch(one, two, k=2), matcher.match(two, one)
    best = {m.queryIdx: m.trainIdx for m in back}
    kept = [
        m
        for m, next_best in there
        if m.distance < RATIO * next_best.distance and best[m.trainIdx] == m.queryIdx
    ]
    if not kept:
        return nothing
    return (
        np.array([points[m.queryIdx].pt for m in kept], np.float64),
        np.array([others[m.trainIdx].pt for m in kept], np.float64),
    )
