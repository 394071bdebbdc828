"""Detections of another detector, by frame: PJPDAF over anybody's 2-D points."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from pjpdaf.arrays import Floats, Ints, readonly
from pjpdaf.camera import Camera, undistort_points
from pjpdaf.frames import StereoFrame
from pjpdaf.interfaces import Detections, Estimates
from pjpdaf.targets import TARGETS

DEFAULT_SD_PX = 3.0
# Where a file gives no areas: visible skin of a head and of a hand, and the distance of a person
# at a table. A tracker that weighs sizes finds them usual.
HEAD_AREA_M2, HAND_AREA_M2, USUAL_DEPTH_M = 0.024, 0.009, 1.2


@dataclass(frozen=True, eq=False)
class DetectionTable:
    """Detections of one view in all frames, sorted by frame.

    frames (n,); centres_px (n, 2) in the picture as filmed, lens distortion included; sd_px (n,)
    standard deviation of a centre per axis; areas_px (n,), NaN where unknown; evidence (n, T)
    log-likelihoods as in `Detections.evidence`, or None.
    """

    frames: Ints
    centres_px: Floats
    sd_px: Floats
    areas_px: Floats
    evidence: Floats | None = None

    @staticmethod
    def empty() -> DetectionTable:
        """A table without detections."""
        return DetectionTable(np.zeros(0, np.intp), np.zeros((0, 2)), np.zeros(0), np.zeros(0))

    def __post_init__(self) -> None:
        n = len(self.frames)
        if np.any(np.diff(self.frames) < 0):
            raise ValueError("DetectionTable.frames must be sorted")
        for name, shape in (("centres_px", (n, 2)), ("sd_px", (n,)), ("areas_px", (n,))):
            value = readonly(getattr(self, name), shape, f"DetectionTable.{name}")
            object.__setattr__(self, name, value)
        if self.evidence is not None:
            value = readonly(self.evidence, (n, None), "DetectionTable.evidence")
            object.__setattr__(self, "evidence", value)


@dataclass(frozen=True, eq=False)
class ExternalDetector:
    """A `Detector` that looks up a frame's detections; it reads no pixels.

    A frame without rows has no detections; a picture that did not arrive is `missing`.
    """

    cameras: tuple[Camera, ...]
    tables: tuple[DetectionTable, ...]

    def learn(self, background: Iterable[StereoFrame]) -> ExternalDetector:
        """Return itself: the other detector has learnt what it needs."""
        return self

    def __call__(
        self, frame: StereoFrame, predicted: Estimates | None = None
    ) -> tuple[Detections, ...]:
        """Return the detections of the frame's index, a record a view."""
        return tuple(
            Detections.none(missing=True)
            if picture is None
            else _detections(camera, table, frame.index)
            for camera, table, picture in zip(
                self.cameras, self.tables, frame.pictures, strict=True
            )
        )


def _detections(camera: Camera, table: DetectionTable, index: int) -> Detections:
    """One view's detections of a frame; discs, since a point has no shape."""
    first, last = np.searchsorted(table.frames, [index, index + 1])
    rows = slice(int(first), int(last))
    n = rows.stop - rows.start
    if n == 0:
        return Detections.none()
    centres = undistort_points(camera, table.centres_px[rows])
    evidence = None if table.evidence is None else table.evidence[rows]
    areas = np.where(
        np.isnan(table.areas_px[rows]), _usual_areas_px(camera, evidence, n), table.areas_px[rows]
    )
    radii = np.sqrt(areas / np.pi)
    return Detections(
        centres,
        (table.sd_px[rows] ** 2)[:, None, None] * np.eye(2),
        np.column_stack([centres, radii, radii, np.zeros(n)]),
        areas,
        evidence=evidence,
    )


def _usual_areas_px(camera: Camera, evidence: Floats | None, n: int) -> Floats:
    """Usual areas (n,) of head or hand, whichever the evidence says; of a hand without any."""
    area_m2 = np.full(n, HAND_AREA_M2)
    if evidence is not None:
        area_m2[evidence.argmax(axis=1) == TARGETS.index("head")] = HEAD_AREA_M2
    focal_px = float(np.sqrt(camera.K[0, 0] * camera.K[1, 1]))
    return np.asarray(area_m2 * (focal_px / USUAL_DEPTH_M) ** 2)
