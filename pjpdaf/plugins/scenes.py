"""Scenes for conformance checks: three slow targets before two cameras, as blobs or pictures."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.camera import Camera, project
from pjpdaf.frames import StereoFrame
from pjpdaf.interfaces import Detections

DT_S = 1 / 3
FRAMES = 12
SKIN_BGR, WALL_BGR = (105, 140, 205), (150, 160, 120)


def cameras_in_front() -> tuple[Camera, Camera]:
    """Two level cameras 1.3 m in front of the person, 90 mm apart, 640x480."""
    K = np.array([[540.0, 0.0, 319.5], [0.0, 540.0, 239.5], [0.0, 0.0, 1.0]])
    R = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, -1.0], [-1.0, 0.0, 0.0]])
    left, right = (Camera(K, R, -R @ np.array([1.3, y, 1.0]), 640, 480) for y in (-0.045, 0.045))
    return left, right


def paths_m(frames: int = FRAMES, dt_s: float = DT_S) -> Floats:
    """Head, right hand, left hand (frames, 3, 3) [m]: slow, hands 0.24 m and more apart."""
    phase = 0.7 * dt_s * np.arange(frames)
    still = np.zeros(frames)
    head = np.stack([0.05 + still, 0.01 * np.sin(phase), 1.2 + still], axis=1)
    right = np.stack([0.35 + still, -0.2 + 0.05 * np.sin(phase), 0.85 + 0.04 * np.cos(phase)], 1)
    left = np.stack([0.35 + still, 0.2 + 0.04 * np.cos(phase), 0.85 + 0.05 * np.sin(phase)], 1)
    return np.stack([head, right, left], axis=1)


def detections_of(
    cameras: tuple[Camera, ...], points_m: Floats, order: Sequence[int]
) -> tuple[Detections, ...]:
    """Detections of a faultless detector of targets (T, 3) [m].

    order: the targets that have a blob, in the order of the blobs of each view.
    """
    order = list(order)
    size = np.array([[40.0, 30.0], [22.0, 16.0], [22.0, 16.0]])[order]
    views = []
    for camera in cameras:
        centres = project(camera, points_m)[order]
        ellipses = np.column_stack([centres, size, np.zeros(len(order))])
        covariances = np.tile(4.0 * np.eye(2), (len(order), 1, 1))
        views.append(Detections(centres, covariances, ellipses, np.pi * size.prod(axis=1)))
    return tuple(views)


def painted(points_m: Floats | None, index: int, seed: int = 0) -> StereoFrame:
    """Both pictures of a wall, with skin-coloured discs where the targets (T, 3) are."""
    rng = np.random.default_rng([seed, index])
    pictures = []
    for camera in cameras_in_front():
        canvas = np.full((480, 640, 3), WALL_BGR, dtype=np.uint8)
        if points_m is not None:
            for centre, size in zip(project(camera, points_m), (40, 24, 24), strict=True):
                x, y = (int(v) for v in np.round(centre))
                cv2.ellipse(canvas, (x, y), (size, round(0.8 * size)), 0, 0, 360, SKIN_BGR, -1)
        noisy = canvas + rng.normal(0, 2.0, canvas.shape)
        picture = np.clip(np.round(noisy), 0, 255).astype(np.uint8)
        picture.flags.writeable = False
        pictures.append(picture)
    return StereoFrame(index, index * DT_S, tuple(pictures))
