"""Stand-in for the blob detector: painted skin to components with their looks."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import final

import cv2
import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.camera import Camera, StereoRig
from pjpdaf.detector.adaptation import AdaptationParameters
from pjpdaf.detector.alignment import LEAST_DEG, moved
from pjpdaf.detector.blob_detector import directions
from pjpdaf.detector.components import Segments, min_area_px, segments
from pjpdaf.detector.detector import numbered
from pjpdaf.detector.ellipses import Moments, moments
from pjpdaf.detector.parameters import DetectorParameters
from pjpdaf.detector.silhouette import reduction, turned
from pjpdaf.frames import StereoFrame
from pjpdaf.interfaces import Detections, Estimates
from pjpdaf.looks import BACKGROUND, CLOTHED, SKIN, BlobLooks, Silhouette
from sim.silhouettes import shapes
from sim.silhouettes.error_model import BlobErrors
from sim.silhouettes.painter import PaintedView, Painter
from sim.silhouettes.skin_blobs import CLOSING, enlarged, quick_axes

STEP_PX = 2  # pictures are painted so much smaller
_LATTICE = 2  # every so many painted pixels of a row and a column are kept
_LEAST_PERSON = 63  # of 255: a pixel that shows as much of the person is unlike the background
_PERSON, _SKIN = np.zeros((2, shapes.PAINTS), np.uint8)
_PERSON[[shapes.CLOTHED, *range(shapes.BARE, shapes.PAINTS)]] = 255
_SKIN[shapes.BARE :] = 255


@final
@dataclass(frozen=True, eq=False)
class BlobsWithLooks:
    """A `pjpdaf.interfaces.Detector` that sees painted frames: `BlobDetector` after segmentation.

    rig: as the tracker is given it; other fields as of `sim.silhouettes.skin_blobs.SkinBlobs`. A
    rotation that the calibration missed is taken out exactly where the detector would look for it.
    """

    rig: StereoRig
    parameters: DetectorParameters
    adaptation: AdaptationParameters
    painter: Painter
    errors: BlobErrors
    _turn: Floats | None = field(init=False, repr=False)

    def __post_init__(self) -> None:
        turn = (
            _missed_turn(self.painter.film.rig, self.rig) if self.adaptation.align_views else None
        )
        object.__setattr__(self, "_turn", turn)

    def learn(self, background: Iterable[StereoFrame]) -> BlobsWithLooks:
        """Return itself: there is nothing to learn."""
        return self

    def __call__(
        self, frame: StereoFrame, predicted: Estimates | None = None
    ) -> tuple[Detections, ...]:
        """Return the detections of each view. predicted: as for `BlobDetector`."""
        return self.painter.detected(
            frame.index, lambda number, view: self._detect(frame.index, number, view, predicted)
        )

    def _detect(
        self, frame: int, number: int, painted: PaintedView, predicted: Estimates | None
    ) -> Detections:
        p, step, camera = self.parameters, painted.step_px, self.rig.cameras[number]
        turn = self._turn if number == 1 else None
        least = min_area_px(p.components, camera, predicted) / step**2
        skin = (painted.classes >= shapes.BARE).view(np.uint8)
        seen = segments(
            cv2.morphologyEx(skin, cv2.MORPH_CLOSE, CLOSING), least, p.components.merge_fragments
        )
        shape = _silhouette(painted, camera)
        if turn is not None:
            shape = turned(shape, turn)
        if seen.count == 0:
            none = np.zeros((0, 2))
            empty = Detections.none()
            looks = BlobLooks((), 1.0, none, none, shape)
            return Detections(
                empty.centres_px,
                empty.covariances_px2,
                empty.ellipses,
                empty.areas_px,
                looks=looks,
            )
        exact = enlarged(moments(seen.points, seen.component, seen.count), step)
        fit = self.errors.applied(exact, frame, number)
        pixels = _lattice(seen, step, fit.centres - exact.centres)
        if turn is not None:
            fit = Moments(moved(fit.centres, turn), fit.covariances, fit.areas)
            pixels = tuple(moved(points, turn) for points in pixels)
        covariances = np.broadcast_to(p.centre_sd_px**2 * np.eye(2), (len(fit), 2, 2))
        each = float((_LATTICE * step) ** 2)
        return Detections(
            fit.centres,
            covariances,
            quick_axes(fit),
            fit.areas,
            looks=BlobLooks(pixels, each, *directions(seen, numbered(seen)), shape),
        )


def _silhouette(painted: PaintedView, camera: Camera) -> Silhouette:
    """The classes of the picture reduced as the detector reduces it."""
    step = reduction(camera.width_px)
    size = max(camera.width_px // step, 1), max(camera.height_px // step, 1)
    person, skin = (
        cv2.resize(table[painted.classes], size, interpolation=cv2.INTER_AREA)
        for table in (_PERSON, _SKIN)
    )
    classes = np.full((size[1], size[0]), BACKGROUND, np.uint8)
    classes[person > _LEAST_PERSON] = CLOTHED
    classes[skin > 127] = SKIN
    return Silhouette(classes, step)


def _lattice(seen: Segments, step: int, moves_px: Floats) -> tuple[Floats, ...]:
    """Each component's pixels on a lattice, in pixels of the whole picture, moved with it."""
    on = ((seen.points[:, 0] % _LATTICE) | (seen.points[:, 1] % _LATTICE)) == 0
    points, component = seen.points[on] * step + (step - 1) / 2, seen.component[on]
    return tuple(points[component == i] + moves_px[i] for i in range(seen.count))


def _missed_turn(filmed: StereoRig, given: StereoRig) -> Floats | None:
    """Map (3, 3) from pixels of the right camera to those of its calibration, None for none."""
    R = given.right.R_cw @ filmed.right.R_cw.T
    angle = np.degrees(np.arccos(np.clip(0.5 * (np.trace(R) - 1.0), -1.0, 1.0)))
    if angle < LEAST_DEG:
        return None
    return np.asarray(given.right.K @ R @ np.linalg.inv(given.right.K))
