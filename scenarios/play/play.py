"""One scenario, one seed: simulate -> detect -> track."""

from __future__ import annotations

import hashlib
import itertools
import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Protocol

from pjpdaf.camera import StereoRig
from pjpdaf.follow import follow
from pjpdaf.frames import StereoFrame
from pjpdaf.interfaces import Detector, Tracker
from pjpdaf.plugins.checked import CheckedDetector, CheckedTracker
from pjpdaf.plugins.registry import make_detector, make_tracker
from pjpdaf.presets.registry import PRESETS
from pjpdaf.tracker.filter import PJPDAF
from reports.pictures.overlay import overlay_jpeg
from reports.pictures.stills import still
from reports.score.records import Episode, FrameOutcome, OverlayPicture, Still
from scenarios.play.blame import blame
from scenarios.play.error_budget import error_budget
from scenarios.spec.draw import concrete, perform
from scenarios.spec.parameters.file import File, contents
from scenarios.spec.scenario import Scenario, digest
from sim.dataset.stored_sequence import StoredSequence
from sim.motion.stage import Value
from sim.sequence import Simulation
from sim.truth import Truth

MAX_PICTURES = 12
EVENLY_SPACED_PICTURES = 5


@dataclass(frozen=True)
class System:
    """What is under test: detector and tracker by name, and changed parameters of each."""

    detector: str = "thesis"
    tracker: str = "thesis"
    detector_settings: Mapping[str, str] = field(default_factory=dict)
    tracker_settings: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Job:
    """One episode to play: a pure function of (scenario, seed, overrides, system).

    keep_pictures: of some frames; keep_film: small and plain, of all frames.
    label: its name in the results, where that is not the scenario's. kept: the folder of a data
    set's sequence that is read instead of rendering the episode; size_px: width and height of its
    pictures, where they are not the scenario's. Files among the overrides are
    found when the job is made: raises BenchError where that fails.
    """

    scenario: Scenario
    seed: int
    overrides: Mapping[str, Value]
    system: System
    keep_pictures: bool = False
    label: str = ""
    keep_film: bool = False
    kept: Path | None = None
    size_px: tuple[int, int] | None = None

    def __post_init__(self) -> None:
        found = dict(self.overrides)
        for name, value in self.overrides.items():
            parameter = self.scenario.parameters.get(name)
            if isinstance(parameter, File):
                found[name] = parameter.check(name, value)
        object.__setattr__(self, "overrides", found)

    @property
    def name(self) -> str:
        """What the results call it."""
        return self.label or self.scenario.name


def digest_of(job: Job) -> str:
    """SHA-256 of an episode: scenario, seed, changed values, what is in its files, its size.

    Same digest, same pictures.

    The system under test is not part of it, so that runs of two trackers can be paired.
    """
    changes = json.dumps(contents(job.overrides), sort_keys=True)
    words = [digest(job.scenario), str(job.seed), changes]
    words += ["{}x{}".format(*job.size_px)] if job.size_px else []
    return hashlib.sha256(" ".join(words).encode()).hexdigest()


def make_system(system: System, rig: StereoRig) -> tuple[Detector, Tracker[Any]]:
    """Detector (background not learnt yet) and tracker for these cameras.

    What a plug-in answers is checked; but for a PJPDAF, whose parts the oracle replaces.
    """
    detector = make_detector(system.detector, rig.cameras, system.detector_settings)
    if system.detector not in PRESETS:
        name = f"detector {system.detector!r}"
        detector = CheckedDetector(name, detector, len(rig.cameras))
    tracker = make_tracker(system.tracker, rig.cameras, system.tracker_settings)
    if not isinstance(tracker, PJPDAF):
        tracker = CheckedTracker(f"tracker {system.tracker!r}", tracker)
    return detector, tracker


def play(job: Job) -> Episode:
    """Play one job to its end.

    Raises what scenario, plug-in or renderer raise; the caller turns that into a failed episode.
    BenchError for a damaged file of a data set.
    """
    if job.kept is not None:
        return play_footage(job, StoredSequence(job.kept, {}))
    with Simulation(perform(job.scenario, job.seed, job.overrides)) as simulation:
        return play_footage(job, simulation)


class Footage(Protocol):
    """What a job plays: a live simulation, or the same kept, such as in a data set."""

    @property
    def fps(self) -> float:
        """Frames a second."""
        ...

    @property
    def frame_count(self) -> int:
        """Frames."""
        ...

    @property
    def redrawn(self) -> int:
        """How many draws of its seed were thrown away (`Performance`)."""
        ...

    @property
    def rig(self) -> StereoRig:
        """The cameras that filmed."""
        ...

    @property
    def calibration(self) -> StereoRig:
        """What the tracker is given."""
        ...

    def background(self) -> list[StereoFrame]:
        """Person-free frames, for learning."""
        ...

    def frames(self) -> Iterator[tuple[StereoFrame, Truth]]:
        """All frames in order."""
        ...


def play_footage(job: Job, footage: Footage) -> Episode:
    """Detect, track and collect what is scored. Raises what a plug-in raises."""
    gallery = Gallery(footage.frame_count) if job.keep_pictures else None
    outcomes = []
    pictures: list[OverlayPicture] = []
    film: list[Still] = []
    detector, tracker = make_system(job.system, footage.calibration)
    detector = detector.learn(footage.background())
    # Frames and truths apart: neither detector nor tracker is near the truth.
    for_loop, for_scores = itertools.tee(footage.frames())
    steps = follow((frame for frame, _ in for_loop), detector, tracker)
    for step, (frame, truth) in zip(steps, for_scores, strict=False):
        stages_s = {"render": step.render_s, "detect": step.detect_s, "track": step.track_s}
        slim = tuple(replace(view, mask=None) for view in step.detections)
        outcomes.append(FrameOutcome(truth, step.estimates, slim, stages_s))
        wanted = gallery is not None and gallery.wants(truth)
        if wanted:
            picture = overlay_jpeg(
                frame, footage.rig.cameras, step.detections, step.estimates, truth
            )
            pictures.append(OverlayPicture(frame.index, picture))
        if wanted or job.keep_film:
            film.append(Still(frame.index, still(frame, footage.rig.cameras)))
    episode = Episode(
        scenario=job.name,
        group=job.scenario.group,
        seed=job.seed,
        fps=footage.fps,
        cameras=footage.rig.cameras,
        frames=tuple(outcomes),
        digest=digest_of(job),
        values=concrete(job.scenario, job.seed, job.overrides, footage.redrawn),
        redrawn=footage.redrawn,
        pictures=tuple(pictures),
        film=tuple(film),
    )
    given = footage.calibration.cameras
    return replace(
        episode,
        blame=blame(episode, given, tracker),
        budget_m=error_budget(episode, given, tracker),
    )


class Gallery:
    """Chooses the frames that are kept as pictures: evenly spaced, and where merges change."""

    def __init__(self, frames: int) -> None:
        step = max(1, (frames - 1) // (EVENLY_SPACED_PICTURES - 1)) if frames > 1 else 1
        self._even = set(range(0, frames, step))
        self._merged: tuple[bool, ...] = ()
        self._left = MAX_PICTURES - len(self._even)

    def wants(self, truth: Truth) -> bool:
        """Whether this frame is one of them; to be asked for every frame, in order."""
        merged = tuple(bool(view.merged.any()) for view in truth.views)
        changed = self._merged != merged and bool(self._merged)
        self._merged = merged
        if truth.index in self._even:
            return True
        if changed and self._left > 0:
            self._left -= 1
            return True
        return False
