"""A played episode tracked again with truth in place of a stage: what would then have happened.

Nothing is rendered: truth and detections of the episode are enough. A stage is replaced by what it
should have given, all others stay as they are:

  detections   one detection per visible target, at the centroid of its visible skin;
  association  the real detections, each given to the target it shows (`PJPDAF.step_assigned`);
  process      the state before every prediction is the truth's position and velocity.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.optimize import linear_sum_assignment

from pjpdaf.arrays import Floats
from pjpdaf.camera import Camera, undistort_points
from pjpdaf.interfaces import AnyTracker, Detections, Estimates
from pjpdaf.tracker.filter import PJPDAF, TrackState
from reports.score.records import Episode, FrameOutcome
from sim.truth import Truth, ViewTruth

STAGES = ("detections", "association", "process")
LEAST_VISIBLE_PX = 20  # fewer skin pixels than this are no detection
SAME_PX = 25.0  # a detection farther from a target's visible centroid does not show it


@dataclass(frozen=True)
class Oracle:
    """Which stages are replaced by truth."""

    detections: bool = False
    association: bool = False
    process: bool = False


def stages_of(tracker: AnyTracker) -> tuple[str, ...]:
    """The stages that can be replaced: of a plug-in, only what it is given."""
    return STAGES if isinstance(tracker, PJPDAF) else STAGES[:1]


def track_again(
    episode: Episode, cameras: Sequence[Camera], tracker: AnyTracker, oracle: Oracle
) -> Episode:
    """The episode with the estimates that the tracker gives under this oracle.

    cameras: the calibration that the tracker was given. Raises ValueError for a stage that this
    tracker does not let be replaced.
    """
    if (oracle.association or oracle.process) and not isinstance(tracker, PJPDAF):
        raise ValueError("association and process can be replaced in a PJPDAF only")
    state: Any = None
    before: Truth | None = None
    outcomes: list[FrameOutcome] = []
    for outcome in episode.frames:
        truth = outcome.truth
        seen = outcome.detections
        if oracle.detections:
            seen = true_detections(truth, seen, cameras)
        if state is None:
            state = tracker.start(seen)
            said = Estimates.waiting() if state is None else tracker.estimates(state)
        else:
            assert before is not None
            dt_s = truth.time_s - before.time_s
            if oracle.process:
                state = on_truth(state, before)
            if oracle.association:
                assert isinstance(tracker, PJPDAF)
                assigned = true_assignment(truth, seen, cameras)
                state, said = tracker.step_assigned(state, assigned, dt_s)
            else:
                state, said = tracker.step(state, seen, dt_s)
        before = truth
        outcomes.append(replace(outcome, estimates=said, detections=seen))
    return replace(episode, frames=tuple(outcomes), pictures=())


def true_detections(
    truth: Truth, seen: Sequence[Detections], cameras: Sequence[Camera]
) -> tuple[Detections, ...]:
    """One detection per target with visible skin, in each view; none where the picture is missing.

    cameras: the calibration that the tracker was given, whose lens is taken out of the centroids.
    """
    return tuple(
        Detections.none(missing=True) if real.missing else _of_view(view, camera)
        for view, real, camera in zip(truth.views, seen, cameras, strict=True)
    )


def _of_view(view: ViewTruth, camera: Camera) -> Detections:
    shown = np.flatnonzero(view.visible_px >= LEAST_VISIBLE_PX)
    if not len(shown):
        return Detections.none()
    centres = undistort_points(camera, view.centroids_px[shown])
    areas = view.visible_px[shown].astype(np.float64)
    # A disc of the same area: the tracker does not read ellipses.
    radii = np.sqrt(areas / math.pi)
    covariances = (radii**2 / 4)[:, None, None] * np.eye(2)
    ellipses = np.column_stack([centres, radii, radii, np.zeros(len(shown))])
    return Detections(centres, covariances, ellipses, areas)


def true_assignment(truth: Truth, seen: Sequence[Detections], cameras: Sequence[Camera]) -> Floats:
    """The detection of each target in each view (N, T, 2) [px], NaN where it has none.

    Detections and visible centroids are paired at least total distance, none beyond SAME_PX: a
    blob of two merged targets lies between them and is given to neither.
    """
    T = len(truth.centres_m)
    assigned = np.full((len(cameras), T, 2), np.nan)
    for n, (view, found, camera) in enumerate(zip(truth.views, seen, cameras, strict=True)):
        shown = np.flatnonzero(view.visible_px >= LEAST_VISIBLE_PX)
        if not len(shown) or not len(found):
            continue
        marks = undistort_points(camera, view.centroids_px[shown])
        far = np.linalg.norm(marks[:, None] - found.centres_px[None], axis=-1)
        rows, columns = linear_sum_assignment(np.minimum(far, 4 * SAME_PX))
        for row, column in zip(rows, columns, strict=True):
            if far[row, column] <= SAME_PX:
                assigned[n, shown[row]] = found.centres_px[column]
    return assigned


def on_truth(state: TrackState, truth: Truth) -> TrackState:
    """The state with the truth's position and velocity as its mean; the covariance stays."""
    mean = np.concatenate([truth.centres_m, truth.velocities_mps], axis=1)
    return replace(state, mean=mean)
