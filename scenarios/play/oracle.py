"""A played episode tracked again with truth in place of a stage: what would then have happened.

Nothing is rendered: truth and detections of the episode are enough. A stage is replaced by what it
should have given, all others stay as they are:

  detections   one detection per visible target, at the centroid of its visible skin;
  association  the real detections, each given to the target it shows
               (`pjpdaf.known_targets.AssociationReplaceable`);
  process      the prediction is the truth (`pjpdaf.known_targets.PredictionReplaceable`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from pjpdaf.camera import Camera
from pjpdaf.follow import follow
from pjpdaf.frames import StereoFrame
from pjpdaf.interfaces import AnyTracker, Detections, Estimates
from pjpdaf.known_targets import AssociationReplaceable, PredictionReplaceable
from pjpdaf.plugins.checked import CheckedTracker
from pjpdaf.recorded import RecordedDetections
from reports.score.records import Episode
from scenarios.play.true_detections import known_targets, true_detections
from sim.truth import Truth

STAGES = ("detections", "association", "process")
Seen = Sequence[tuple[Detections, ...]]  # detections of each frame, per view


@dataclass(frozen=True)
class Oracle:
    """Which stages are replaced by truth."""

    detections: bool = False
    association: bool = False
    process: bool = False


def stages_of(tracker: AnyTracker) -> tuple[str, ...]:
    """The stages that can be replaced: what a tracker is given, and what it lets be replaced."""
    plain = tracker.tracker if isinstance(tracker, CheckedTracker) else tracker
    replaceable = {
        "detections": True,
        "association": isinstance(plain, AssociationReplaceable),
        "process": isinstance(plain, PredictionReplaceable),
    }
    return tuple(stage for stage in STAGES if replaceable[stage])


def track_again(
    episode: Episode,
    cameras: Sequence[Camera],
    tracker: AnyTracker,
    oracle: Oracle,
    seen: Seen | None = None,
    lag: int = 0,
) -> Episode:
    """The episode with the estimates that the tracker gives under this oracle.

    cameras: the calibration that the tracker was given. seen: the detections with their looks,
    which an episode does not keep; None for the episode's; lag: as of `follow`. Raises ValueError
    for a stage that this tracker does not let be replaced.
    """
    for stage in STAGES:
        if getattr(oracle, stage) and stage not in stages_of(tracker):
            raise ValueError(f"this tracker does not let its {stage} be replaced")
    truths = tuple(outcome.truth for outcome in episode.frames)
    recorded = tuple(outcome.detections for outcome in episode.frames)
    recorded = recorded if seen is None else tuple(seen)
    if oracle.detections:
        recorded = tuple(
            true_detections(truth, real, cameras)
            for truth, real in zip(truths, recorded, strict=True)
        )
    if oracle.association or oracle.process:
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

    state: Any
    frame: int


@dataclass(frozen=True, eq=False)
class AidedTracker:
    """A `Tracker` whose association or process model is replaced by the truth.

    tracker: one that lets the oracle's stages be replaced; truths: of all frames that it will be
    given, in order; cameras: as calibrated.
    """

    tracker: Any
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
        known = known_targets(self.truths[frame], detections, self.cameras)
        if self.oracle.process:
            state = self.tracker.expecting(state, known, dt_s)
        if self.oracle.association:
            state, estimates = self.tracker.step_associated(state, detections, known, dt_s)
        else:
            state, estimates = self.tracker.step(state, detections, dt_s)
        return AidedState(state, frame), estimates

    def estimates(self, aided: AidedState) -> Estimates:
        """Return the tracker's estimates; waiting before its start."""
        if aided.state is None:
            return Estimates.waiting()
        estimates: Estimates = self.tracker.estimates(aided.state)
        return estimates

    def predict(self, aided: AidedState, dt_s: float) -> Estimates:
        """Return the tracker's prediction; waiting before its start."""
        if aided.state is None:
            return Estimates.waiting()
        prediction: Estimates = self.tracker.predict(aided.state, dt_s)
        return prediction

    def smoothed(self, aided: tuple[AidedState, ...]) -> Estimates:
        """Return the estimates of a tracker that looks back; waiting before its start."""
        states = tuple(one.state for one in aided if one.state is not None)
        if aided[0].state is None:
            return Estimates.waiting()
        estimates: Estimates = self.tracker.smoothed(states)
        return estimates
