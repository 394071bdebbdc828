"""Hands and head detection (thesis 3.1): pictures to measurements."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from dataclasses import dataclass, field

import cv2
import numpy as np

from pjpdaf.camera import Camera, to_camera
from pjpdaf.detector.background import (
    Background,
    BackgroundSums,
    BackgroundTest,
    is_foreground,
    prepare,
)
from pjpdaf.detector.blobs import (
    Segments,
    clean,
    cluster,
    ellipse_axes,
    moments,
    segments,
    undistort_moments,
)
from pjpdaf.detector.skin import SkinRange, skin_mask, to_hsv
from pjpdaf.errors import BenchError
from pjpdaf.frames import StereoFrame
from pjpdaf.interfaces import Detections, Estimates
from pjpdaf.presets.parameters import DetectorParameters

Maps = tuple[np.ndarray, np.ndarray]


@dataclass(frozen=True, eq=False)
class SkinDetector:
    """The thesis's detector: skin and foreground, components, k-means hypotheses, ellipses.

    cameras: one a view; parameters: section 3.1's; backgrounds: one a view as learnt, or empty for
    skin alone; keep_masks: put the accepted pixels into `Detections.mask`.
    """

    cameras: tuple[Camera, ...]
    parameters: DetectorParameters
    backgrounds: tuple[Background, ...] = ()
    keep_masks: bool = False
    _tests: tuple[BackgroundTest, ...] = field(init=False, repr=False)
    _maps: tuple[Maps | None, ...] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        p = self.parameters
        if self.backgrounds and len(self.backgrounds) != len(self.cameras):
            raise BenchError(
                f"The detector has {len(self.cameras)} cameras but {len(self.backgrounds)} "
                "backgrounds: learn them with this rig."
            )
        for view, (camera, background) in enumerate(
            zip(self.cameras, self.backgrounds, strict=False)
        ):
            height, width = background.mean.shape[:2]
            if (width, height) != (camera.width_px, camera.height_px):
                raise BenchError(
                    f"View {view}: the background is {width}x{height} px, the camera "
                    f"{camera.width_px}x{camera.height_px}: learn it again."
                )
        floors = (p.hue_sd_floor_deg, p.sat_sd_floor, p.val_sd_floor)
        tests = tuple(
            prepare(b, p.background_threshold, *floors, p.shadow_min) for b in self.backgrounds
        )
        object.__setattr__(self, "_tests", tests)
        whole = p.undistort == "picture"
        maps = tuple(_undistortion_maps(c) if whole else None for c in self.cameras)
        object.__setattr__(self, "_maps", maps)

    @property
    def skin(self) -> SkinRange:
        """The skin range of the parameters."""
        p = self.parameters
        return SkinRange(p.hue_range_deg, p.saturation_range, p.value_min)

    def learn(self, background: Iterable[StereoFrame]) -> SkinDetector:
        """A detector that knows the person-free scene; frames are read one at a time.

        Raises BenchError where a view has fewer than background_learn_min pictures.
        """
        sums = tuple(BackgroundSums() for _ in self.cameras)
        for frame in background:
            for view, picture in enumerate(self._pictures(frame)):
                if picture is not None:
                    sums[view].add(picture)
        least = self.parameters.background_learn_min
        return dataclasses.replace(self, backgrounds=tuple(s.result(least) for s in sums))

    def __call__(
        self, frame: StereoFrame, predicted: Estimates | None = None
    ) -> tuple[Detections, ...]:
        """One `Detections` a view. `predicted` only gives the depth that scales min_area_px.

        Raises BenchError for a picture of the wrong size or type; a missing one is `missing`.
        """
        return tuple(
            Detections.none(missing=True)
            if picture is None
            else self._detect(view, picture, predicted)
            for view, picture in enumerate(self._pictures(frame))
        )

    def segment(self, view: int, picture: np.ndarray, min_area_px: float) -> Segments:
        """Accepted skin pixels of a view's (undistorted, if so chosen) picture, by component."""
        p = self.parameters
        hsv = to_hsv(picture)
        mask = skin_mask(hsv, self.skin)
        if self._tests:
            at = np.flatnonzero(mask.view(np.bool_))
            same = at[~is_foreground(self._tests[view], hsv, at)]
            mask.reshape(-1)[same] = 0
        return segments(clean(mask, p.open_px, p.close_px), min_area_px, p.merge_fragments)

    def _detect(self, view: int, picture: np.ndarray, predicted: Estimates | None) -> Detections:
        p, camera = self.parameters, self.cameras[view]
        seen = self.segment(view, picture, min_area_px(p, camera, predicted))
        mask = _mask(seen) if self.keep_masks else None
        if seen.count == 0:
            return dataclasses.replace(Detections.none(), mask=mask)
        labels = cluster(
            seen, p.extra_hypotheses, p.kmeans_penalty, p.subsample, p.components_compete
        )
        fit = moments(seen.points, labels, int(labels.max()) + 1)
        if p.undistort == "points":
            fit = undistort_moments(camera, fit)
        covariances = np.broadcast_to(p.centre_sd_px**2 * np.eye(2), (len(fit), 2, 2))
        return Detections(fit.centres, covariances, ellipse_axes(fit), fit.areas, mask=mask)

    def _pictures(self, frame: StereoFrame) -> tuple[np.ndarray | None, ...]:
        """The frame's pictures, checked, and undistorted where pictures are to be."""
        if len(frame.pictures) != len(self.cameras):
            raise BenchError(
                f"Frame {frame.index} has {len(frame.pictures)} pictures, the rig "
                f"{len(self.cameras)} cameras."
            )
        checked: list[np.ndarray | None] = []
        for view, (camera, picture) in enumerate(zip(self.cameras, frame.pictures, strict=True)):
            if picture is None:
                checked.append(None)
                continue
            _check(frame.index, view, camera, picture)
            maps = self._maps[view]
            if maps is not None:
                picture = cv2.remap(picture, *maps, cv2.INTER_LINEAR)
            checked.append(picture)
        return tuple(checked)


def min_area_px(p: DetectorParameters, camera: Camera, predicted: Estimates | None) -> float:
    """Smallest component of this view [px]: areas go with (f / Z)^2.

    Z is the median depth of the targets that `predicted` says are tracked; without any,
    reference_depth_m. The scale for depth is kept within 1/4 .. 4, as a prediction may be wrong.
    """
    area = p.min_area_px
    if p.reference_focal_px > 0:
        area *= camera.K[0, 0] * camera.K[1, 1] / p.reference_focal_px**2
    if p.reference_depth_m > 0 and predicted is not None:
        tracked = np.array([s == "tracked" for s in predicted.status], dtype=bool)
        depths = to_camera(camera, predicted.positions_m[tracked])[:, 2]
        depths = depths[np.isfinite(depths) & (depths > 0)]
        if len(depths):
            area *= min(max((p.reference_depth_m / float(np.median(depths))) ** 2, 0.25), 4.0)
    return float(area)


def with_skin(p: DetectorParameters, skin: SkinRange) -> DetectorParameters:
    """Parameters with a skin range as learnt (`pjpdaf.detector.skin.learn_skin_range`)."""
    return dataclasses.replace(
        p,
        hue_range_deg=skin.hue_deg,
        saturation_range=skin.saturation,
        value_min=skin.value_min,
    )


def _undistortion_maps(camera: Camera) -> Maps | None:
    """Fixed-point maps for cv2.remap to the ideal pinhole with the same K, made once."""
    if not np.any(camera.distortion):
        return None
    K = np.array(camera.K)
    size = (camera.width_px, camera.height_px)
    x, y = cv2.initUndistortRectifyMap(
        K, np.array(camera.distortion), np.eye(3), K, size, cv2.CV_16SC2
    )
    return x, y


def _check(index: int, view: int, camera: Camera, picture: np.ndarray) -> None:
    if picture.dtype != np.uint8 or picture.ndim != 3 or picture.shape[2] != 3:
        raise BenchError(
            f"Frame {index}, view {view}: the picture must be uint8 BGR (h, w, 3), "
            f"got {picture.dtype} {picture.shape}."
        )
    height, width = picture.shape[:2]
    if (width, height) != (camera.width_px, camera.height_px):
        raise BenchError(
            f"Frame {index}, view {view}: the picture is {width}x{height} px, the camera "
            f"{camera.width_px}x{camera.height_px}: use the calibration of this resolution."
        )


def _mask(seen: Segments) -> np.ndarray:
    mask = np.zeros(seen.size, np.uint8)
    mask[seen.points[:, 1], seen.points[:, 0]] = 255
    return mask
