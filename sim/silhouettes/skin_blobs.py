"""Stand-in for the thesis's detector: painted skin to clusters and ellipses."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from typing import final

import numpy as np

from pjpdaf.arrays import Ints
from pjpdaf.camera import Camera
from pjpdaf.detector.clusters import ClusterParameters, cluster
from pjpdaf.detector.components import Segments, min_area_px, segments
from pjpdaf.detector.ellipses import Moments, ellipse_axes, moments
from pjpdaf.detector.parameters import DetectorParameters
from pjpdaf.frames import StereoFrame
from pjpdaf.interfaces import Detections, Estimates
from sim.silhouettes.error_model import BlobErrors
from sim.silhouettes.painter import PaintedView, Painter
from sim.silhouettes.shapes import BARE

STEP_PX = 4  # pictures are painted so much smaller
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

    def __post_init__(self) -> None:
        # The painted pixels are the sample of every fourth row and column already.
        whole = replace(self.parameters.clusters, subsample=1)
        object.__setattr__(self, "_all_pixels", whole)

    def learn(self, background: Iterable[StereoFrame]) -> SkinBlobs:
        """Return itself: there is nothing to learn."""
        return self

    def __call__(
        self, frame: StereoFrame, predicted: Estimates | None = None
    ) -> tuple[Detections, ...]:
        """Return the detections of each view. predicted: as for `SkinDetector`."""
        views = self.painter.paint(frame.index)
        return tuple(
            self._detect(frame.index, number, view, predicted)
            if self.painter.film.moments[frame.index].arrived[number]
            else Detections.none(missing=True)
            for number, view in enumerate(views)
        )

    def _detect(
        self, frame: int, number: int, painted: PaintedView, predicted: Estimates | None
    ) -> Detections:
        p, step = self.parameters, painted.step_px
        least = min_area_px(p.components, self.cameras[number], predicted) / step**2
        mask = (painted.classes >= BARE).view(np.uint8)
        seen = segments(mask, least, p.components.merge_fragments)
        if seen.count == 0:
            return Detections.none()
        labels = self._cluster(seen)
        fit = enlarged(moments(seen.points, labels, int(labels.max()) + 1), step)
        fit = self.errors.applied(fit, frame, number)
        covariances = np.broadcast_to(p.centre_sd_px**2 * np.eye(2), (len(fit), 2, 2))
        return Detections(fit.centres, covariances, ellipse_axes(fit), fit.areas)

    def _cluster(self, seen: Segments) -> Ints:
        if seen.count == _APART and self._all_pixels.components_compete:
            return seen.component
        return cluster(seen, self._all_pixels)


def enlarged(fit: Moments, step: int) -> Moments:
    """Moments of a picture reduced by a whole number, in pixels of the whole picture."""
    return Moments(
        fit.centres * step + (step - 1) / 2, fit.covariances * step**2, fit.areas * step**2
    )
