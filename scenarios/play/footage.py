"""The footage that a job plays: a live simulation, or a stored sequence of a data set."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Protocol

from pjpdaf.camera import StereoRig
from pjpdaf.frames import StereoFrame
from scenarios.play.job import Job
from scenarios.play.recipe import sized
from scenarios.spec.draw import perform
from sim.dataset.stored_sequence import StoredSequence
from sim.sequence import Simulation
from sim.truth import Truth


class Footage(Protocol):
    """The frames that a job plays: of a live simulation, or stored, as in a data set."""

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

    def background(self) -> list[StereoFrame]:
        """Person-free frames, for learning."""
        ...

    def frames(self) -> Iterator[tuple[StereoFrame, Truth]]:
        """All frames in order."""
        ...


@contextmanager
def open_footage(job: Job) -> Iterator[Footage]:
    """The footage of a job, ready to be played. Raises what scenario or renderer raise."""
    if job.kept is not None:
        yield StoredSequence(job.kept, {})
        return
    performance = sized(perform(job.scenario, job.seed, job.overrides), job.size_px)
    with Simulation(performance) as simulation:
        yield simulation
