"""One episode: footage -> detector -> tracker -> the records that are scored."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

from pjpdaf.camera import Camera, StereoRig
from pjpdaf.detector.external import DetectionTable, ExternalDetector
from pjpdaf.follow import FollowedFrame, follow
from pjpdaf.interfaces import Detections, Detector, Tracker
from pjpdaf.plugins.checked import CheckedDetector, checked_tracker
from pjpdaf.plugins.registry import make_detector, make_tracker
from pjpdaf.presets.registry import PRESETS
from reports.score.records import Episode, FrameOutcome
from scenarios.play.blame import with_blame
from scenarios.play.error_budget import with_error_budget
from scenarios.play.footage import Footage, open_footage
from scenarios.play.job import Job, System, digest_of
from scenarios.play.kept_detections import watched
from scenarios.play.kept_film import KeptFilm
from scenarios.play.pictures import PictureCollector
from scenarios.spec.draw import concrete
from sim.recording.recording import Recording
from sim.steps import step as count_step
from sim.truth import Truth


def make_system(
    system: System, rig: StereoRig, detections: tuple[DetectionTable, ...] | None = None
) -> tuple[Detector, Tracker[Any]]:
    """Detector (background not learnt yet) and tracker for these cameras.

    detections: looked up instead of detected. The answers of a plug-in are checked.
    """
    detector: Detector
    if detections is not None:
        detector = ExternalDetector(rig.cameras, detections)
    else:
        detector = make_detector(system.detector, rig.cameras, system.detector_settings)
        if system.detector not in PRESETS:
            name = f"detector {system.detector!r}"
            detector = CheckedDetector(name, detector, len(rig.cameras))
    tracker = make_tracker(system.tracker, rig.cameras, system.tracker_settings)
    if system.tracker not in PRESETS:
        tracker = checked_tracker(f"tracker {system.tracker!r}", tracker)
    return detector, tracker


def play(job: Job) -> Episode:
    """Play a job to its end; the bare episode: without blame, error budget, pictures and film.

    Raises what scenario, plug-in or renderer raise, BenchError for a damaged file of a data set.
    """
    with open_footage(job) as footage:
        detector, tracker = make_system(job.system, footage.calibration, job.detections)
        return with_origin(play_footage(job, footage, detector, tracker), footage)


def play_complete(job: Job) -> Episode:
    """Play a job to its end, with everything that a saved run keeps of it. Raises as `play`."""
    with open_footage(job) as footage:
        return complete_episode(job, footage)


def complete_episode(job: Job, footage: Footage) -> Episode:
    """Play footage; the episode with blame, error budget, pictures and film. Raises as `play`."""
    cameras = footage.calibration.cameras
    detector, tracker = make_system(job.system, footage.calibration, job.detections)
    kept_film = KeptFilm(job, footage)
    film = kept_film.read()
    collector = PictureCollector(
        footage.rig.cameras,
        footage.frame_count,
        pictures=job.keep_pictures,
        film=job.keep_film and film is None,
    )
    seen: list[tuple[Detections, ...]] = []  # with the looks, which the episode does not keep

    def keep(step: FollowedFrame, truth: Truth) -> None:
        seen.append(tuple(replace(view, mask=None) for view in step.detections))
        collector.add(step, truth)

    episode = play_footage(job, footage, detector, tracker, keep)
    episode = with_blame(episode, cameras, tracker, seen, job.system.lag)
    episode = with_error_budget(episode, cameras, tracker, seen, job.system.lag)
    episode = with_origin(collector.added_to(episode), footage)
    if film is not None:
        return replace(episode, film=film)
    kept_film.write(episode.film)
    return episode


def with_origin(episode: Episode, footage: Footage) -> Episode:
    """The episode with the origin of its pictures."""
    replayed = isinstance(footage, Recording)
    return replace(episode, renderer=footage.renderer, replayed=replayed)


def play_footage(
    job: Job,
    footage: Footage,
    detector: Detector,
    tracker: Tracker[Any],
    on_frame: Callable[[FollowedFrame, Truth], None] = lambda step, truth: None,
) -> Episode:
    """Detect and track in all frames; the bare episode. Raises what a plug-in raises.

    Kept detections (`watched`) have the times that they took once.

    detector: its background is learnt here; on_frame: called for every frame, with its truth.
    """
    outcomes = []
    with watched(job, footage, detector) as (learnt, frames, reused_s):
        # Frames and truths apart: neither detector nor tracker is near the truth.
        for_loop, for_scores = itertools.tee(frames)
        steps = follow((frame for frame, _ in for_loop), learnt, tracker, job.system.lag)
        for step, (_, truth) in zip(steps, for_scores, strict=False):
            detect_s = reused_s.get(step.frame.index, step.detect_s)
            outcomes.append(outcome_of(replace(step, detect_s=detect_s), truth))
            on_frame(step, truth)
            count_step()
    episode = episode_of(job, footage.rig.cameras, footage.fps, outcomes, footage.redrawn)
    return replace(episode, detections_kept=len(reused_s) == len(outcomes))


def outcome_of(step: FollowedFrame, truth: Truth) -> FrameOutcome:
    """What an episode keeps of a followed frame: detections without masks and looks."""
    return FrameOutcome(
        truth,
        step.estimates,
        tuple(
            view
            if view.mask is None and view.looks is None
            else replace(view, mask=None, looks=None)
            for view in step.detections
        ),
        {"render": step.render_s, "detect": step.detect_s, "track": step.track_s},
    )


def episode_of(
    job: Job,
    cameras: tuple[Camera, ...],
    fps: float,
    outcomes: Sequence[FrameOutcome],
    redrawn: int,
) -> Episode:
    """The bare episode of a job. cameras: as they really are; redrawn: draws thrown away."""
    return Episode(
        scenario=job.name,
        group=job.scenario.group,
        seed=job.seed,
        fps=fps,
        cameras=cameras,
        frames=tuple(outcomes),
        digest=digest_of(job),
        values=concrete(job.scenario, job.seed, job.overrides, redrawn),
        redrawn=redrawn,
    )
