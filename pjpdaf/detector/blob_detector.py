"""Blob detector: skin components with their pixels, and a silhouette of the person."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import final

import cv2
import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.camera import Camera, undistort_points
from pjpdaf.detector.background import Background, BackgroundSums, BackgroundTest, prepare
from pjpdaf.detector.blobs import Segments, ellipse_axes, moments, undistort_moments
from pjpdaf.detector.detector import SkinDetector, min_area_px
from pjpdaf.detector.silhouette import Silhouette, reduced, silhouette
from pjpdaf.frames import StereoFrame
from pjpdaf.interfaces import Detections, Estimates
from pjpdaf.presets.parameters import DetectorParameters

LATTICE_PX = 640 // 3  # pixels of a blob are kept on a lattice of about this many columns


@dataclass(frozen=True, eq=False)
class BlobDetections(Detections):
    """Detections of one view whose blobs carry their pixels.

    pixels: per blob (n, 2) undistorted pixels on a lattice; each stands for pixel_area_px pixels.
    fingers: per blob (n, 2) from the middle of its widest part, the palm, to its centroid, over the
    square root of its area; undirected blobs have about 0. silhouette: of the view.
    """

    pixels: tuple[Floats, ...] = ()
    pixel_area_px: float = 1.0
    fingers: Floats | None = None
    silhouette: Silhouette | None = field(default=None, repr=False)


@final
@dataclass(frozen=True, eq=False)
class BlobDetector:
    """Skin components, each a detection, with pixels and silhouette; no clustering.

    base: the thesis's detector, which segments; small: backgrounds of the reduced pictures.
    """

    base: SkinDetector
    small: tuple[Background, ...] = ()
    _tests: tuple[BackgroundTest, ...] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        p = self.base.parameters
        # Averaging takes most of the noise out of reduced pictures.
        floors = (p.hue_sd_floor_deg, 0.8 * p.sat_sd_floor, 0.6 * p.val_sd_floor)
        tests = tuple(
            prepare(b, p.background_threshold, *floors, p.shadow_min) for b in self.small
        )
        object.__setattr__(self, "_tests", tests)

    @staticmethod
    def of(cameras: tuple[Camera, ...], parameters: DetectorParameters) -> BlobDetector:
        """A detector that has learnt no background yet."""
        return BlobDetector(SkinDetector(cameras, parameters))

    def learn(self, background: Iterable[StereoFrame]) -> BlobDetector:
        """A detector that knows the person-free scene."""
        frames = list(background)
        base = self.base.learn(frames)
        sums = tuple(BackgroundSums() for _ in self.base.cameras)
        for frame in frames:
            for view, picture in enumerate(frame.pictures):
                if picture is not None:
                    sums[view].add(reduced(picture))
        least = self.base.parameters.background_learn_min
        return BlobDetector(base, tuple(s.result(least) for s in sums))

    def __call__(
        self, frame: StereoFrame, predicted: Estimates | None = None
    ) -> tuple[BlobDetections, ...]:
        """One record a view. `predicted` only gives the depth that scales min_area_px."""
        return tuple(
            self._none(missing=True) if picture is None else self._detect(view, picture, predicted)
            for view, picture in enumerate(frame.pictures)
        )

    def _detect(
        self, view: int, picture: np.ndarray, predicted: Estimates | None
    ) -> BlobDetections:
        p, camera = self.base.parameters, self.base.cameras[view]
        seen = self.base.segment(view, picture, min_area_px(p, camera, predicted))
        mask = np.zeros(seen.size, np.uint8)
        mask[seen.points[:, 1], seen.points[:, 0]] = 255
        shape = silhouette(picture, mask, self._tests[view] if self._tests else None)
        if seen.count == 0:
            return dataclasses.replace(self._none(), silhouette=shape)
        fit = undistort_moments(camera, moments(seen.points, seen.component, seen.count))
        covariances = np.broadcast_to(p.centre_sd_px**2 * np.eye(2), (len(fit), 2, 2))
        pixels, each = _lattice(seen, camera)
        return BlobDetections(
            fit.centres,
            covariances,
            ellipse_axes(fit),
            fit.areas,
            pixels=pixels,
            pixel_area_px=each,
            fingers=_fingers(seen, mask),
            silhouette=shape,
        )

    @staticmethod
    def _none(missing: bool = False) -> BlobDetections:
        empty = np.zeros((0, 2)), np.zeros((0, 2, 2)), np.zeros((0, 5)), np.zeros(0)
        return BlobDetections(*empty, missing)


def _fingers(seen: Segments, mask: np.ndarray) -> Floats:
    """Vectors (count, 2) from each component's palm to its centroid, over sqrt(area)."""
    found = np.zeros((seen.count, 2))
    for i in range(seen.count):
        points = seen.points[seen.component == i]
        low, high = points.min(axis=0), points.max(axis=0)
        box = mask[low[1] : high[1] + 1, low[0] : high[0] + 1]
        inside = np.zeros((box.shape[0] + 2, box.shape[1] + 2), np.uint8)
        inside[points[:, 1] - low[1] + 1, points[:, 0] - low[0] + 1] = 1
        depth = cv2.distanceTransform(inside, cv2.DIST_L2, 3)
        widest = np.argwhere(depth > 0.9 * depth.max()).mean(axis=0)[::-1] - 1 + low
        found[i] = (points.mean(axis=0) - widest) / len(points) ** 0.5
    return found


def _lattice(seen: Segments, camera: Camera) -> tuple[tuple[Floats, ...], float]:
    """Each component's pixels on a lattice, undistorted, and how many pixels one stands for."""
    step = max(1, round(camera.width_px / LATTICE_PX))
    on = (seen.points[:, 0] % step == 0) & (seen.points[:, 1] % step == 0)
    points, component = undistort_points(camera, seen.points[on]), seen.component[on]
    return tuple(points[component == i] for i in range(seen.count)), float(step * step)
