"""Stand-in for the thesis's detector: painted skin to clusters and ellipses."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from itertools import combinations
from math import atan2, hypot, sqrt
from operator import itemgetter
from typing import final

import cv2
import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Floats
from pjpdaf.camera import Camera
from pjpdaf.detector.clusters import ClusterParameters
from pjpdaf.detector.components import Segments, min_area_px, segments
from pjpdaf.detector.ellipses import Moments, moments
from pjpdaf.detector.parameters import DetectorParameters
from pjpdaf.frames import StereoFrame
from pjpdaf.interfaces import Detections, Estimates
from sim.silhouettes.clustering import chosen_clusters
from sim.silhouettes.error_model import BlobErrors
from sim.silhouettes.painter import PaintedView, Painter
from sim.silhouettes.patches import Patches, T, apart
from sim.silhouettes.shapes import BARE

STEP_PX = 2  # pictures are painted so much smaller
CLOSING = cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3))  # as the detector's of 5 px
_SAMPLE = 2  # of the painted pixels each way, where they are searched for components
_MOST_SCALED = 4.0  # the least area of a near person over that of the reference depth, at most
_APART = 3  # components that are taken for the blobs: k-means is not asked


@final
@dataclass(frozen=True, eq=False)
class SkinBlobs:
    """A `pjpdaf.interfaces.Detector` that sees painted frames: `SkinDetector` after segmentation.

    cameras: as the tracker is given them; parameters: of the detector that it stands for; painter:
    of the film whose frames it is asked for; errors: what is added to the blobs.
    """

    cameras: tuple[Camera, ...]
    parameters: DetectorParameters
    painter: Painter
    errors: BlobErrors
    _all_pixels: ClusterParameters = field(init=False, repr=False)
    _simple: bool = field(init=False, repr=False)
    _centre_covariances: Floats = field(init=False, repr=False)
    _surely_px: list[float] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        whole = replace(self.parameters.clusters, subsample=1)  # of the sampled pixels
        object.__setattr__(self, "_all_pixels", whole)
        other_skin = any(view.other_skin for view in self.painter.film.outlines)
        object.__setattr__(self, "_simple", whole.components_compete and not other_skin)
        least = [min_area_px(self.parameters.components, c, None) for c in self.cameras]
        object.__setattr__(self, "_surely_px", [_MOST_SCALED * area for area in least])
        one = self.parameters.centre_sd_px**2 * np.eye(2)
        object.__setattr__(self, "_centre_covariances", np.tile(one, (T, 1, 1)))

    def learn(self, background: Iterable[StereoFrame]) -> SkinBlobs:
        """Return itself: there is nothing to learn."""
        return self

    def __call__(
        self, frame: StereoFrame, predicted: Estimates | None = None
    ) -> tuple[Detections, ...]:
        """Return the detections of each view. predicted: as for `SkinDetector`."""
        return self.painter.detected(
            frame.index, lambda number, view: self._detect(frame.index, number, view, predicted)
        )

    def _detect(
        self, frame: int, number: int, painted: PaintedView, predicted: Estimates | None
    ) -> Detections:
        p, step = self.parameters, painted.step_px
        # Larger than this counts, whatever is predicted; the median of the depths takes its time.
        if self._simple and _plain(painted.patches, self._surely_px[number] / step**2):
            return self._plain_blobs(painted, frame, number)
        least = min_area_px(p.components, self.cameras[number], predicted) / step**2
        if self._simple and _plain(painted.patches, least):
            return self._plain_blobs(painted, frame, number)
        seen = segments(_mask(painted), least / _SAMPLE**2, p.components.merge_fragments)
        if seen.count == 0:
            return Detections.none()
        fit = self._clusters(seen)
        sampled = Moments(
            fit.centres * _SAMPLE, fit.covariances * _SAMPLE**2, fit.areas * _SAMPLE**2
        )
        return self._detections(enlarged(sampled, step), frame, number)

    def _plain_blobs(self, painted: PaintedView, frame: int, number: int) -> Detections:
        """Blobs of a picture in which each target is a component: without looking for them.

        With plain numbers: arrays of three rows cost more than they save.
        """
        step, area = painted.step_px, painted.step_px**2
        centres, ellipses, areas = [], [], []
        moves = self.errors.moves(frame, number)
        seen = sorted(((p.y, p) for p in painted.patches if p is not None), key=itemgetter(0))
        for (_, patch), (dx, dy) in zip(seen, moves, strict=False):
            xx, yy = patch.xx + 1 / 12, patch.yy + 1 / 12
            half, mean = 0.5 * (xx - yy), 0.5 * (xx + yy)
            reach = hypot(half, patch.xy)
            x, y = patch.x * step + (step - 1) / 2 + dx, patch.y * step + (step - 1) / 2 + dy
            long, short = sqrt(mean + reach), sqrt(max(mean - reach, 0.0))
            turned = 0.5 * atan2(patch.xy, half)
            centres.append((x, y))
            ellipses.append((x, y, 2.0 * step * long, 2.0 * step * short, turned))
            areas.append(patch.pixels * area)
        return Detections(
            np.array(centres), self._centre_covariances, np.array(ellipses), np.array(areas)
        )

    def _detections(self, exact: Moments, frame: int, number: int) -> Detections:
        fit = self.errors.applied(exact, frame, number)
        covariances = self._centre_covariances[: len(fit)]
        if len(covariances) < len(fit):
            covariances = np.broadcast_to(covariances[0], (len(fit), 2, 2))
        return Detections(fit.centres, covariances, quick_axes(fit), fit.areas)

    def _clusters(self, seen: Segments) -> Moments:
        if seen.count == _APART and self._all_pixels.components_compete:
            return moments(seen.points, seen.component, seen.count)
        return chosen_clusters(seen, self._all_pixels)


def _mask(painted: PaintedView) -> NDArray[np.uint8]:
    """Skin of every other row and column, closed: the detector's own sample of the whole picture.

    Closed only where skin is: that takes a third of the time.
    """
    height, width = painted.classes.shape
    mask = np.zeros((-(-height // _SAMPLE), -(-width // _SAMPLE)), np.uint8)
    left, top, right, bottom = painted.skin_box
    if left < right and top < bottom:
        skin = (painted.classes[top:bottom, left:right] >= BARE).view(np.uint8)
        closed = cv2.morphologyEx(skin, cv2.MORPH_CLOSE, CLOSING)[::_SAMPLE, ::_SAMPLE]
        window = mask[top // _SAMPLE :, left // _SAMPLE :]
        window[: closed.shape[0], : closed.shape[1]] = closed
    return mask


def _plain(patches: Patches, least: float) -> bool:
    """Whether each target is a component of its own, large enough, and far from the others."""
    boxes = []
    for patch in patches:
        if patch is None or patch.pieces != 1 or patch.pixels < least:
            return False
        boxes.append(patch.box)
    return all(apart(a, b, 2) for a, b in combinations(boxes, 2))


def enlarged(fit: Moments, step: int) -> Moments:
    """Moments of a picture reduced by a whole number, in pixels of the whole picture."""
    return Moments(
        fit.centres * step + (step - 1) / 2, fit.covariances * step**2, fit.areas * step**2
    )


def quick_axes(fit: Moments) -> Floats:
    """`pjpdaf.detector.ellipses.ellipse_axes` in closed form."""
    C = fit.covariances
    half, off = 0.5 * (C[:, 0, 0] - C[:, 1, 1]), C[:, 0, 1]
    mean, reach = 0.5 * (C[:, 0, 0] + C[:, 1, 1]), np.hypot(half, off)
    axes = np.empty((len(fit), 5))
    axes[:, :2] = fit.centres
    axes[:, 2] = 2.0 * np.sqrt(mean + reach)
    axes[:, 3] = 2.0 * np.sqrt(np.maximum(mean - reach, 0.0))
    axes[:, 4] = 0.5 * np.arctan2(off, half)
    return axes
