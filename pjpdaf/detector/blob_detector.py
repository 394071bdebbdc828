"""Blob detector: skin components with their looks, for a tracker that splits them itself."""

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
from pjpdaf.detector.components import Segments, min_area_px
from pjpdaf.detector.detector import SkinDetector
from pjpdaf.detector.ellipses import ellipse_axes, moments, undistort_moments
from pjpdaf.detector.parameters import DetectorParameters
from pjpdaf.detector.silhouette import reduced, silhouette
from pjpdaf.frames import StereoFrame
from pjpdaf.interfaces import Detections, Estimates
from pjpdaf.looks import BlobLooks

LATTICE_COLUMNS = 213  # pixels of a blob are kept on a lattice of about this many columns
THIN = 0.5  # half-width of a finger over that of a palm, at most; a wrist's is about 0.7
QUIETER = 0.8, 0.6  # floors of the deviations of S and V: averaging takes most of the noise out


@final
@dataclass(frozen=True, eq=False)
class BlobDetector:
    """Skin components, each a detection, with pixels and silhouette; no clustering.

    base: the thesis's detector, which segments; its 'undistort' and 'clusters' have no effect.
    small: backgrounds of the reduced pictures, of the views as learnt, or empty.
    """

    base: SkinDetector
    small: tuple[Background, ...] = ()
    _tests: tuple[BackgroundTest, ...] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        p = self.base.parameters.background
        quiet = dataclasses.replace(
            p, sat_sd_floor=QUIETER[0] * p.sat_sd_floor, val_sd_floor=QUIETER[1] * p.val_sd_floor
        )
        object.__setattr__(self, "_tests", tuple(prepare(b, quiet) for b in self.small))

    @staticmethod
    def of(cameras: tuple[Camera, ...], parameters: DetectorParameters) -> BlobDetector:
        """Return a detector that has learnt no background yet."""
        return BlobDetector(SkinDetector(cameras, parameters))

    def learn(self, background: Iterable[StereoFrame]) -> BlobDetector:
        """Return a detector that knows the person-free scene; frames are read one at a time.

        Raises BenchError where a view has fewer than background_learn_min pictures.
        """
        sums = tuple(BackgroundSums() for _ in self.base.cameras)

        def watched() -> Iterable[StereoFrame]:
            for frame in background:
                yield frame  # the base checks it first
                for view, picture in enumerate(frame.pictures):
                    if picture is not None:
                        sums[view].add(reduced(picture))

        base = self.base.learn(watched())
        least = base.parameters.background.background_learn_min
        return BlobDetector(base, tuple(s.result(least) for s in sums))

    def __call__(
        self, frame: StereoFrame, predicted: Estimates | None = None
    ) -> tuple[Detections, ...]:
        """Return the detections of each view. predicted: for the depth that scales min_area_px.

        Raises BenchError for a picture of the wrong size or type; a missing picture is `missing`.
        """
        return tuple(
            Detections.none(missing=True)
            if picture is None
            else self._detect(view, picture, predicted)
            for view, picture in enumerate(self.base.checked(frame))
        )

    def _detect(self, view: int, picture: np.ndarray, predicted: Estimates | None) -> Detections:
        p, camera = self.base.parameters, self.base.cameras[view]
        seen = self.base.segment(view, picture, min_area_px(p.components, camera, predicted))
        mask = np.zeros(seen.size, np.uint8)
        mask[seen.points[:, 1], seen.points[:, 0]] = 255
        shape = silhouette(picture, mask, self._tests[view] if self._tests else None, camera)
        if seen.count == 0:
            none = np.zeros((0, 2))
            nothing = BlobLooks((), 1.0, none, none, shape)
            return dataclasses.replace(Detections.none(), looks=nothing)
        fit = undistort_moments(camera, moments(seen.points, seen.component, seen.count))
        covariances = np.broadcast_to(p.centre_sd_px**2 * np.eye(2), (len(fit), 2, 2))
        pixels, each = _lattice(seen, camera)
        return Detections(
            fit.centres,
            covariances,
            ellipse_axes(fit),
            fit.areas,
            mask=mask if self.base.keep_masks else None,
            looks=BlobLooks(pixels, each, *directions(seen), shape),
        )


def directions(seen: Segments) -> tuple[Floats, Floats]:
    """Vectors of each component (count, 2), over sqrt(area): `BlobLooks.palms` and `fingers`.

    The palm is the middle of where the component is widest: the tops of its distance transform.
    Thin is what an opening by a disc of THIN of that width takes away.
    """
    palms, thin_parts = np.zeros((seen.count, 2)), np.zeros((seen.count, 2))
    for i in range(seen.count):
        points = seen.points[seen.component == i]
        low = points.min(axis=0)
        width, height = points.max(axis=0) - low + 3  # a rim of 1 px all round
        inside = np.zeros((height, width), np.uint8)
        inside[points[:, 1] - low[1] + 1, points[:, 0] - low[0] + 1] = 1
        depth = cv2.distanceTransform(inside, cv2.DIST_L2, 3)
        widest = np.argwhere(depth > 0.9 * depth.max()).mean(axis=0)[::-1]
        root = len(points) ** 0.5
        palms[i] = (points.mean(axis=0) - (widest - 1 + low)) / root
        size = 2 * max(1, round(THIN * float(depth.max()))) + 1
        disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (size, size))
        rest = inside - cv2.morphologyEx(inside, cv2.MORPH_OPEN, disc)
        thin = np.argwhere(rest > 0)[:, ::-1]
        if len(thin):
            thin_parts[i] = (thin - widest).sum(axis=0) / len(points) / root
    return palms, thin_parts


def _lattice(seen: Segments, camera: Camera) -> tuple[tuple[Floats, ...], float]:
    """Each component's pixels on a lattice, undistorted, and how many pixels one stands for."""
    step = max(1, round(camera.width_px / LATTICE_COLUMNS))
    on = (seen.points[:, 0] % step == 0) & (seen.points[:, 1] % step == 0)
    points, component = undistort_points(camera, seen.points[on]), seen.component[on]
    return tuple(points[component == i] for i in range(seen.count)), float(step * step)
