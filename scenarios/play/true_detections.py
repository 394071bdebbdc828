"""Detections and associations that a frame's truth gives in place of the real ones."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pjpdaf.arrays import Floats, Ints
from pjpdaf.camera import Camera, undistort_points
from pjpdaf.interfaces import Detections
from pjpdaf.known_targets import KnownTargets
from pjpdaf.looks import BlobLooks, looks_of_ellipses
from reports.score.assignment import assignment
from sim.truth import Truth, ViewTruth

LEAST_VISIBLE_PX = 20  # fewer skin pixels than this are no detection
SAME_PX = 25.0  # a detection farther from a target's visible centroid does not show it


def true_detections(
    truth: Truth, seen: Sequence[Detections], cameras: Sequence[Camera]
) -> tuple[Detections, ...]:
    """One detection per target with visible skin, in each view; none where the picture is missing.

    Merged targets have a detection each. cameras: the calibration that the tracker was given, whose
    lens is taken out of the centroids. Looks, where the real detections have them: the silhouette
    is the real one; fingers and palm are those of the real detection that shows the target.
    """
    shown_by = shown_detections(truth, seen, cameras)
    return tuple(
        Detections.none(missing=True) if real.missing else _of_view(view, real, mine, camera)
        for view, real, mine, camera in zip(truth.views, seen, shown_by, cameras, strict=True)
    )


def _of_view(view: ViewTruth, real: Detections, shown_by: Ints, camera: Camera) -> Detections:
    shown = np.flatnonzero(view.visible_px >= LEAST_VISIBLE_PX)
    if not len(shown):
        none = np.zeros((0, 2))
        silhouette = None if real.looks is None else real.looks.silhouette
        looks = None if real.looks is None else BlobLooks((), 1.0, none, none, silhouette)
        return replace(Detections.none(), looks=looks)
    centres = undistort_points(camera, view.centroids_px[shown])
    areas = view.visible_px[shown].astype(np.float64)
    # An upright ellipse of the same area, as long and as wide as the box of the visible skin.
    tall = np.sqrt(view.boxes_px[shown, 3] / view.boxes_px[shown, 2])
    radii = np.sqrt(areas / math.pi)
    across, down = radii / tall, radii * tall
    covariances = np.zeros((len(shown), 2, 2))
    covariances[:, 0, 0], covariances[:, 1, 1] = across**2 / 4, down**2 / 4
    turn = np.where(down > across, math.pi / 2, 0.0)
    major, minor = np.maximum(across, down), np.minimum(across, down)
    ellipses = np.column_stack([centres, major, minor, turn])
    looks = None if real.looks is None else _looks(ellipses, real.looks, shown_by[shown])
    return Detections(centres, covariances, ellipses, areas, looks=looks)


def _looks(ellipses: Floats, real: BlobLooks, shown_by: Ints) -> BlobLooks:
    """Looks of ellipses (n, 5); shown_by (n,): the real blob of each, -1 none."""
    palms, fingers = np.zeros((len(ellipses), 2)), np.zeros((len(ellipses), 2))
    known = shown_by >= 0
    palms[known] = real.palms[shown_by[known]]
    fingers[known] = real.fingers[shown_by[known]]
    return replace(
        looks_of_ellipses(ellipses), palms=palms, fingers=fingers, silhouette=real.silhouette
    )


def shown_detections(truth: Truth, seen: Sequence[Detections], cameras: Sequence[Camera]) -> Ints:
    """Number of the detection that shows each target in each view (N, T), -1 where none does.

    Detections and visible centroids are paired at least total distance, none beyond SAME_PX: a
    blob of two merged targets lies between them and shows neither.
    """
    shown_by = np.full((len(cameras), len(truth.centres_m)), -1)
    for n, (view, detections, camera) in enumerate(zip(truth.views, seen, cameras, strict=True)):
        shown = np.flatnonzero(view.visible_px >= LEAST_VISIBLE_PX)
        if not len(shown) or not len(detections):
            continue
        marks = undistort_points(camera, view.centroids_px[shown])
        far = np.linalg.norm(marks[:, None] - detections.centres_px[None], axis=-1)
        rows, columns = assignment(np.minimum(far, 4 * SAME_PX))
        for row, column in zip(rows, columns, strict=True):
            if far[row, column] <= SAME_PX:
                shown_by[n, shown[row]] = column
    return shown_by


def known_targets(
    truth: Truth, seen: Sequence[Detections], cameras: Sequence[Camera]
) -> KnownTargets:
    """The truth of a frame, as far as it may be given to a tracker in place of a stage."""
    shown_by = shown_detections(truth, seen, cameras)
    return KnownTargets(truth.centres_m, truth.velocities_mps, shown_by)
