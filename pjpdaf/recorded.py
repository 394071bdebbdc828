"""A detector that gives detections recorded before."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from pjpdaf.frames import StereoFrame
from pjpdaf.interfaces import Detections, Estimates


@dataclass(frozen=True)
class RecordedDetections:
    """A `Detector` whose answer to frame i is the recorded detections i; it reads no pictures."""

    recorded: tuple[tuple[Detections, ...], ...]

    def learn(self, background: Iterable[StereoFrame]) -> RecordedDetections:
        """Return itself: a recording has nothing to learn."""
        return self

    def __call__(
        self, frame: StereoFrame, predicted: Estimates | None = None
    ) -> tuple[Detections, ...]:
        """Return the detections of the frame's index."""
        return self.recorded[frame.index]

    def frames(self, times_s: Iterable[float]) -> Iterable[StereoFrame]:
        """Yield a frame without pictures for each of the recording's times."""
        for index, time_s in enumerate(times_s):
            yield StereoFrame(index, time_s, ())
