"""Hands and head detection (thesis 3.1): pictures to measurements."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from dataclasses import dataclass, field

import cv2
import numpy as np

from pjpdaf.arrays import Ints
from pjpdaf.camera import Camera
from pjpdaf.detector.background import (
    Background,
    BackgroundSums,
    BackgroundTest,
    is_foreground,
    prepare,
)
from pjpdaf.detector.clusters import cluster
from pjpdaf.detector.components import Segments, clean, min_area_px, segments
from pjpdaf.detector.ellipses import ellipse_axes, moments
from pjpdaf.detector.guidance import ANY, Guidance, Scope
from pjpdaf.detector.parameters import DetectorParameters
from pjpdaf.detector.skin import skin_mask, to_hsv
from pjpdaf.detector.undistortion import Maps
from pjpdaf.errors import BenchError
from pjpdaf.frames import StereoFrame
from pjpdaf.interfaces import Detections, Estimates

HOLES_PX = 11  # diameter of the holes that are closed where they have the colour of skin


@dataclass(frozen=True, eq=False)
class SkinDetector:
    """The thesis's detector: skin and foreground, components, k-means hypotheses, ellipses.

    cameras: of the views; parameters: section 3.1's; backgrounds: of the views as learnt, or empty
    for skin alone; keep_masks: put the accepted pixels into `Detections.mask`.
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
        tests = tuple(prepare(background, p.background) for background in self.backgrounds)
        object.__setattr__(self, "_tests", tests)
        maps = tuple(p.undistort.maps(camera) for camera in self.cameras)
        object.__setattr__(self, "_maps", maps)

    def learn(self, background: Iterable[StereoFrame]) -> SkinDetector:
        """Return a detector that knows the person-free scene; frames are read one at a time.

        Raises BenchError where a view has fewer than background_learn_min pictures.
        """
        sums = tuple(BackgroundSums() for _ in self.cameras)
        for frame in background:
            for view, picture in enumerate(self.checked(frame)):
                if picture is not None:
                    sums[view].add(picture)
        least = self.parameters.background.background_learn_min
        return dataclasses.replace(self, backgrounds=tuple(s.result(least) for s in sums))

    def __call__(
        self, frame: StereoFrame, predicted: Estimates | None = None
    ) -> tuple[Detections, ...]:
        """Return the detections of each view. predicted: for the depth that scales min_area_px.

        Raises BenchError for a picture of the wrong size or type; a missing picture is `missing`.
        """
        return self.detect(frame, predicted)[0]

    @property
    def recipe(self) -> str:
        """All parameters, as a text."""
        return repr((type(self).__name__, self.parameters, self.keep_masks))

    def guidance(self, predicted: Estimates | None) -> tuple[Guidance, ...]:
        """Return what each view's detections take from a prediction."""
        p = self.parameters.components
        return tuple(Guidance(min_area_px(p, camera, predicted)) for camera in self.cameras)

    def detect(
        self, frame: StereoFrame, predicted: Estimates | None = None
    ) -> tuple[tuple[Detections, ...], tuple[Scope, ...]]:
        """Return the detections of each view, and the guidance for which each is the same."""
        found = [
            (Detections.none(missing=True), ANY)
            if picture is None
            else self._detect(view, picture, guidance)
            for view, (picture, guidance) in enumerate(
                zip(self.checked(frame), self.guidance(predicted), strict=True)
            )
        ]
        detections, scopes = zip(*found, strict=True)
        return detections, scopes

    def segment(
        self,
        view: int,
        picture: np.ndarray,
        min_area_px: float,
        balanced: np.ndarray | None = None,
        coloured: np.ndarray | None = None,
        no_skin: np.ndarray | None = None,
    ) -> Segments:
        """Return accepted skin pixels of a view's picture as it is searched, by component.

        balanced: the same picture in the light of the skin range, for the test of skin alone.
        coloured: uint8 (h, w), 0 or 1, a reduced picture's foreground by another test.
        no_skin: likewise, what has the colour of skin and is none: clothes, uncovered background.
        """
        p = self.parameters
        hsv = to_hsv(picture)
        mask = skin_mask(hsv if balanced is None else to_hsv(balanced), p.skin)
        if no_skin is not None:
            mask[_enlarged(no_skin, hsv) > 127] = 0
        if self._tests:
            at = np.flatnonzero(mask.view(np.bool_))
            if coloured is not None:  # the cheaper test leaves few pixels to the other
                at = at[_enlarged(coloured, hsv).reshape(-1).take(at) < 128]
            same = at[~is_foreground(self._tests[view], hsv, at)]
            mask.reshape(-1)[same] = 0
            if coloured is not None and len(same):
                # Holes of a hand on a surface of its own colour.
                mask.reshape(-1)[same] = _closed_at(mask, same, p.components.open_px)
        cleaned = clean(mask, p.components.open_px, p.components.close_px)
        return segments(cleaned, min_area_px, p.components.merge_fragments)

    def _detect(
        self, view: int, picture: np.ndarray, guidance: Guidance
    ) -> tuple[Detections, Scope]:
        p, camera = self.parameters, self.cameras[view]
        seen = self.segment(view, picture, guidance.min_area_px)
        scope = Scope(seen.above_px, seen.upto_px)
        mask = skin_of(seen) if self.keep_masks else None
        if seen.count == 0:
            return dataclasses.replace(Detections.none(), mask=mask), scope
        labels = cluster(seen, p.clusters)
        fit = moments(seen.points, labels, int(labels.max()) + 1)
        fit = p.undistort.moments(camera, fit)
        covariances = np.broadcast_to(p.centre_sd_px**2 * np.eye(2), (len(fit), 2, 2))
        found = Detections(fit.centres, covariances, ellipse_axes(fit), fit.areas, mask=mask)
        return found, scope

    def checked(self, frame: StereoFrame) -> tuple[np.ndarray | None, ...]:
        """Check the frame's pictures, and undistort them where whole pictures are undistorted."""
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


def _closed_at(mask: np.ndarray, at: Ints, open_px: int) -> np.ndarray:
    """Pixels (n,) of a mask (h, w), flat indices, opened and its holes of HOLES_PX closed."""
    rows, columns = np.divmod(at, mask.shape[1])
    rim = max(open_px, 0) + HOLES_PX  # as far as the elements reach, so that nothing changes here
    top, left = max(int(rows.min()) - rim, 0), max(int(columns.min()) - rim, 0)
    window = mask[top : int(rows.max()) + rim + 1, left : int(columns.max()) + rim + 1]
    return np.asarray(clean(window, open_px, HOLES_PX)[rows - top, columns - left])


def _enlarged(mask: np.ndarray, picture: np.ndarray) -> np.ndarray:
    """Enlarge a mask of 0 or 1 to a picture's size: uint8 0..255."""
    size = (picture.shape[1], picture.shape[0])
    wide: np.ndarray = cv2.resize(mask * np.uint8(255), size, interpolation=cv2.INTER_LINEAR)
    return wide


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


def numbered(seen: Segments) -> np.ndarray:
    """Numbers of the components from 1 on, int32 (h, w), 0 outside."""
    return _drawn(seen, np.zeros(seen.size, np.int32), seen.component + 1)


def skin_of(seen: Segments) -> np.ndarray:
    """The pixels of all components, uint8 (h, w), 255 inside."""
    return _drawn(seen, np.zeros(seen.size, np.uint8), 255)


def _drawn(seen: Segments, picture: np.ndarray, values: np.ndarray | int) -> np.ndarray:
    """The picture (h, w) with values at the pixels of all components."""
    columns, rows = seen.points.T
    picture.reshape(-1)[rows * seen.size[1] + columns] = values
    return picture
