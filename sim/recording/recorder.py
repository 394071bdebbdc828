"""A simulation that is recorded while it is played."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, BinaryIO

from pjpdaf.camera import StereoRig
from pjpdaf.frames import StereoFrame
from sim.camera.stereo_sensor import Light, background_frames
from sim.recording.truths import FrameFacts
from sim.recording.writer import RecordingWriter
from sim.sequence import Simulation
from sim.truth import Truth


class RecordedSimulation:
    """Gives the frames of a simulation, and writes them into a file.

    key: what decides the pictures, plain values. The file is whole, and `complete` true, after the
    last frame. A disk that refuses to write ends the recording only.
    """

    def __init__(self, simulation: Simulation, file: BinaryIO, key: Mapping[str, Any]) -> None:
        self._simulation, self._key = simulation, key
        self._writer = RecordingWriter(file)
        self._background: Light | None = None
        self._begun = False
        self.complete = False

    @property
    def fps(self) -> float:
        """Frame rate [1/s]."""
        return self._simulation.fps

    @property
    def frame_count(self) -> int:
        """Number of frames."""
        return self._simulation.frame_count

    @property
    def redrawn(self) -> int:
        """Number of rejected draws of the seed (`sim.script.Performance`)."""
        return self._simulation.redrawn

    @property
    def rig(self) -> StereoRig:
        """The cameras that film."""
        return self._simulation.rig

    @property
    def calibration(self) -> StereoRig:
        """The calibration that a tracker is given."""
        return self._simulation.calibration

    @property
    def renderer(self) -> str:
        """Description of the OpenGL renderer."""
        return self._simulation.renderer

    def background(self) -> list[StereoFrame]:
        """The person-free frames, as `sim.sequence.Simulation.background` gives them."""
        performance = self._simulation.performance
        count, sensor = performance.background_frames, performance.scene.sensor
        if count == 0:
            return []
        light = self._background_light()
        return background_frames(light, count, performance.fps, sensor, performance.seed)

    def frames(self) -> Iterator[tuple[StereoFrame, Truth]]:
        """Yield all frames in order with their truth. A second time nothing is recorded."""
        if self._begun:
            yield from self._simulation.frames()
            return
        self._begun = True
        if self._simulation.performance.background_frames:
            self._background_light()  # the first in the file
        for index in range(self.frame_count):
            rendered = self._simulation.render(index)
            frame, truth = rendered.frame, rendered.truth
            arrived = tuple(picture is not None for picture in frame.pictures)
            self._writer.add_frame(rendered.light, FrameFacts(truth, frame.time_s, arrived))
            yield frame, truth
        self._writer.finish(self._simulation, self._key)
        self.complete = not self._writer.failed

    def _background_light(self) -> Light:
        if self._background is None:
            self._background = self._simulation.background_light()
            self._writer.add_light(self._background)
        return self._background
