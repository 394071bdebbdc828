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

import numpy as np
from scipy.optimize import linear_sum_assignment

from pjpdaf.arrays import Floats
from pjpdaf.camera import Camera, undistort_points
from pjpdaf.follow import follow
from pjpdaf.frames import StereoFrame
from pjpdaf.interfaces import AnyTracker, Detections, Estimates
from pjpdaf.recorded import RecordedDetections
from pjpdaf.tracker.filter import PJPDAF
from pjpdaf.tracker.state import TrackState
from reports.score.records import Episode
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
    episode: Episode, cameras: Sequence[Camera], tracker: AnyTracker, oracle: Oracle, lag: int = 0
) -> Episode:
    """The episode with the estimates that the tracker gives under this oracle.

    cameras: the calibration that the tracker was given; lag: as of `follow`. Raises ValueError for
    a stage that this tracker does not let be replaced.
    """
    if (oracle.association or oracle.process) and not isinstance(tracker, PJPDAF):
        raise ValueError("association and process can be replaced in a PJPDAF only")
    truths = tuple(outcome.truth for outcome in episode.frames)
    recorded = tuple(outcome.detections for outcome in episode.frames)
    if oracle.detections:
        recorded = tuple(
            true_detections(truth, seen, cameras)
            for truth, seen in zip(truths, recorded, strict=True)
        )
    if isinstance(tracker, PJPDAF) and (oracle.association or oracle.process):
        tracker = AidedTracker(tracker, tuple(cameras), truths, oracle)
    frames = (StereoFrame(number, truth.time_s, ()) for number, truth in enumerate(truths))
    steps = follow(frames, RecordedDetections(recorded), tracker, lag)
    outcomes = tuple(
        replace(outcome, estimates=step.estimates, detections=step.detections)
        for outcome, step in zip(episode.frames, steps, strict=True)
    )
    return replace(episode, frames=outcomes, pictures=())


@dataclass(frozen=True, eq=False)
class AidedState:
    """State of an `AidedTracker`: the tracker's, None before its start, and the frame's number."""

    state: TrackState | None
    frame: int


@dataclass(frozen=True, eq=False)
class AidedTracker:
    """A `Tracker`: a PJPDAF whose association or process model is replaced by the truth.

    truths: of all frames that it will be given, in order; cameras: as calibrated.
    """

    tracker: PJPDAF
    cameras: tuple[Camera, ...]
    truths: tuple[Truth, ...]
    oracle: Oracle

    def start(self, detections: tuple[Detections, ...]) -> AidedState:
        """Take the first frame. It counts even where the tracker waits: frames are numbered."""
        return AidedState(self.tracker.start(detections), 0)

    def step(
        self, aided: AidedState, detections: tuple[Detections, ...], dt_s: float
    ) -> tuple[AidedState, Estimates]:
        """Step the tracker with truth in place of the oracle's stages; start it if it waits."""
        frame, state = aided.frame + 1, aided.state
        if state is None:
            after = AidedState(self.tracker.start(detections), frame)
            return after, self.estimates(after)
        if self.oracle.process:
            state = state_on_truth(state, self.truths[frame - 1])
        if self.oracle.association:
            assigned = true_assignment(self.truths[frame], detections, self.cameras)
            state, estimates = self.tracker.step_assigned(state, assigned, dt_s)
        else:
            state, estimates = self.tracker.step(state, detections, dt_s)
        return AidedState(state, frame), estimates

    def estimates(self, aided: AidedState) -> Estimates:
        """Return the tracker's estimates; waiting before its start."""
        if aided.state is None:
            return Estimates.waiting()
        return self.tracker.estimates(aided.state)

    def predict(self, aided: AidedState, dt_s: float) -> Estimates:
        """Return the tracker's prediction; waiting before its start."""
        if aided.state is None:
            return Estimates.waiting()
        return self.tracker.predict(aided.state, dt_s)


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
    for n, (view, detections, camera) in enumerate(zip(truth.views, seen, cameras, strict=True)):
        shown = np.flatnonzero(view.visible_px >= LEAST_VISIBLE_PX)
        if not len(shown) or not len(detections):
            continue
        marks = undistort_points(camera, view.centroids_px[shown])
        far = np.linalg.norm(marks[:, None] - detections.centres_px[None], axis=-1)
        rows, columns = linear_sum_assignment(np.minimum(far, 4 * SAME_PX))
        for row, column in zip(rows, columns, strict=True):
            if far[row, column] <= SAME_PX:
                assigned[n, shown[row]] = detections.centres_px[column]
    return assigned


def state_on_truth(state: TrackState, truth: Truth) -> TrackState:
    """The state with the truth's position and velocity as its mean; the covariance stays."""
    mean = np.concatenate([truth.centres_m, truth.velocities_mps], axis=1)
    return replace(state, mean=mean)
