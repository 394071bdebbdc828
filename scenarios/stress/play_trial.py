"""A trial played in a worker: its episode, reduced to what stress needs of it."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from itertools import groupby

import numpy as np

from pjpdaf.errors import BenchError, PlugInFault
from pjpdaf.follow import FollowedFrame
from pjpdaf.plugins.loading import describe_exception
from pjpdaf.targets import TARGETS
from reports.score.events import find_events
from reports.score.records import Episode, FailureKind
from reports.score.robustness import robustness
from scenarios.play.blame import blame
from scenarios.play.fast import play_fast
from scenarios.play.footage import Footage, open_footage
from scenarios.play.job import Job
from scenarios.play.play import make_system, play_footage
from scenarios.spec.cameras import rig_of
from scenarios.spec.draw import concrete, fault_of_draw, in_si
from scenarios.stress.case import Trial, TrialFailure, TrialResult
from sim.contact.contact import Unposable
from sim.truth import Truth

LEAST_VISIBLE_SHARE = 0.2  # of a target's own pixels; with fewer it counts as hidden


def play_trial(trial: Trial) -> TrialResult | BenchError:
    """Play a trial; a fault of plug-in or pose becomes its failure.

    A fault of the machine, or of a system that cannot be played so, is returned.

    A fast episode is not judged before it is played: where it fails, and a person could not perform
    it, its failure is "unposable" and it counts as nothing.
    """
    started = time.process_time()
    job = trial.case.job(trial.system)
    try:
        rig_of(in_si(job.scenario, concrete(job.scenario, job.seed, job.overrides)))
    except BenchError as fault:
        return _failure(trial.key, "unposable", str(fault))  # as of a lens that shows points twice
    try:
        if trial.fidelity == "fast":
            result = _fast(job, trial.key)
        else:
            with open_footage(job) as footage:
                result = full_result(job, trial.key, footage)
    except BenchError as fault:
        return fault
    except Unposable as fault:
        return _failure(trial.key, "unposable", str(fault))
    except PlugInFault as fault:
        return _failure(trial.key, "plug-in", str(fault))
    except (Exception, SystemExit, KeyboardInterrupt) as fault:
        return _failure(trial.key, "exception", describe_exception(fault))
    return replace(result, cpu_s=time.process_time() - started)


def result_of(key: str, episode: Episode) -> TrialResult:
    """The result of a played episode, with the blame that it carries."""
    return TrialResult(
        key=key,
        robustness=robustness(episode),
        events=find_events(episode),
        frames=len(episode.frames),
        fps=episode.fps,
        occluded_frames=occluded_frames(episode),
        blame=episode.blame,
    )


def occluded_frames(episode: Episode) -> tuple[int, ...]:
    """Of each target, the longest run of frames in which no view shows it as itself."""
    runs = []
    for target in range(len(TARGETS)):
        hidden = [
            all(
                view.visible_fractions[target] < LEAST_VISIBLE_SHARE
                or bool(np.any(view.merged[target]))
                for view in outcome.truth.views
            )
            for outcome in episode.frames
        ]
        runs.append(max([0, *(len(list(run)) for dark, run in groupby(hidden) if dark)]))
    return tuple(runs)


def _fast(job: Job, key: str) -> TrialResult:
    result = result_of(key, play_fast(job))
    fault = fault_of_draw(job.scenario, job.seed, job.overrides) if result.failed else None
    return result if fault is None else _failure(key, "unposable", fault)


def full_result(
    job: Job,
    key: str,
    footage: Footage,
    on_frame: Callable[[FollowedFrame, Truth], None] = lambda step, truth: None,
) -> TrialResult:
    """The result of a job's footage, with the stages to blame for its events.

    on_frame: as of `play_footage`. Raises Unposable where a person could not perform the job's own
    draw: another draw in its place would be another case; and what `play_footage` raises.
    """
    if footage.redrawn:
        raise Unposable(str(fault_of_draw(job.scenario, job.seed, job.overrides)))
    detector, tracker = make_system(job.system, footage.calibration)
    episode = play_footage(job, footage, detector, tracker, on_frame)
    stages = blame(episode, footage.calibration.cameras, tracker)
    return result_of(key, replace(episode, blame=stages))


def _failure(key: str, kind: FailureKind, reason: str) -> TrialResult:
    return TrialResult(key, None, failure=TrialFailure(kind, reason))
