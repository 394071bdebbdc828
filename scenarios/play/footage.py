"""The footage that a job plays: live, from the cache, or a stored sequence of a data set."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Protocol

from pjpdaf.camera import StereoRig
from pjpdaf.frames import StereoFrame
from scenarios.cache.key import FootageKey, footage_key
from scenarios.cache.renderer import asked_renderer, known_renderer, remember
from scenarios.cache.settings import cache_settings
from scenarios.cache.store import FootageCache
from scenarios.play.job import Job, digest_of
from scenarios.play.recipe import sized
from scenarios.spec.draw import perform
from scenarios.spec.motion.plugged import PluggedMotion
from sim.recording.recorder import RecordedSimulation
from sim.script import Performance
from sim.sequence import Simulation
from sim.truth import Truth


class Footage(Protocol):
    """The frames that a job plays: of a live simulation, recorded, or stored in a data set."""

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
        """The calibration that the tracker is given."""
        ...

    @property
    def renderer(self) -> str:
        """Description of the OpenGL renderer that drew it, "" where that is not known."""
        ...

    def background(self) -> list[StereoFrame]:
        """Person-free frames, for learning."""
        ...

    def frames(self) -> Iterator[tuple[StereoFrame, Truth]]:
        """All frames in order."""
        ...


@contextmanager
def open_footage(job: Job) -> Iterator[Footage]:
    """The footage of a job, ready to be played. Raises what scenario or renderer raise.

    What is rendered is kept in the cache, and comes from there the next time.
    """
    if job.kept is not None:
        # Late: only who plays a data set needs to read Parquet.
        from sim.dataset.stored_sequence import StoredSequence

        yield StoredSequence(job.kept, {})
        return
    cache = footage_cache(job)
    if cache is None:
        with Simulation(performance_of(job)) as simulation:
            yield simulation
        return
    key = key_of(job)
    recording = cache.open(key, renderer_here(cache.settings.folder))
    if recording is not None:
        with recording:
            yield recording
        return
    with Simulation(performance_of(job)) as simulation:
        remember(cache.settings.folder, simulation.renderer)
        with cache.pending(key, simulation.renderer) as pending:
            if pending is None:
                yield simulation
                return
            recorded = RecordedSimulation(simulation, pending.file, key.record)
            try:
                yield recorded
            finally:  # of a plug-in that fails the pictures are good, if it has seen all
                pending.keep = recorded.complete


def footage_cache(job: Job) -> FootageCache | None:
    """The cache that a job's pictures come from and go to, None where it uses none.

    A plug-in's motion uses none: no key can know all the code that it runs.
    """
    used = job.use_cache and job.kept is None and not is_plugged_motion(job)
    settings = cache_settings() if used else None
    return None if settings is None else FootageCache(settings)


def is_plugged_motion(job: Job) -> bool:
    """Whether a plug-in plays the motion of a job that is rendered."""
    return job.kept is None and isinstance(job.scenario.motion, PluggedMotion)


def plugged_motions(jobs: Iterable[Job]) -> set[str]:
    """Names of the plug-ins that play the motions of jobs."""
    return {job.scenario.motion.kind for job in jobs if is_plugged_motion(job)}


def key_of(job: Job) -> FootageKey:
    """The key of a job's footage."""
    return footage_key(digest_of(job), job.scenario.twins)


def is_cached(job: Job, *, anyhow: bool = False) -> bool:
    """Whether a job's pictures are in the cache, as far as can be told without OpenGL.

    anyhow: also those of another renderer, which are played where there is no OpenGL.
    """
    cache = footage_cache(job)
    if cache is None:
        return False
    renderer = known_renderer(cache.settings.folder)
    return (renderer is not None or anyhow) and cache.find(key_of(job), renderer) is not None


def remembered_renderer(job: Job) -> str:
    """The renderer of a job's cached pictures, "" where it is not remembered."""
    cache = footage_cache(job)
    return "" if cache is None else known_renderer(cache.settings.folder) or ""


def renderer_here(folder: Path) -> str | None:
    """The renderer that would draw here; None without OpenGL: then that of any entry will do."""
    return known_renderer(folder) or asked_renderer(folder)


def performance_of(job: Job) -> Performance:
    """The performance of a job. Raises BenchError, Unposable."""
    return sized(perform(job.scenario, job.seed, job.overrides), job.size_px)
