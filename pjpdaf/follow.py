"""The loop that follows a person through frames: detector and tracker, a frame at a time."""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import TypeVar

from pjpdaf.errors import PlugInFault
from pjpdaf.frames import StereoFrame
from pjpdaf.interfaces import Detections, Detector, Estimates, Tracker

State = TypeVar("State")


@dataclass(frozen=True, eq=False)
class FollowedFrame:
    """A frame with the detections and estimates that it led to.

    detections: per view; estimates: of the tracker after this frame, `Estimates.waiting()` before
    its start; dt_s: time since the frame before [s], 0 for the first. render_s: time until the
    frame was there, rendered or read [s]; detect_s: the detector's [s]; track_s: the tracker's, its
    prediction for the detector included [s].
    """

    frame: StereoFrame
    detections: tuple[Detections, ...]
    estimates: Estimates
    dt_s: float
    render_s: float
    detect_s: float
    track_s: float


def follow(
    frames: Iterable[StereoFrame], detector: Detector, tracker: Tracker[State]
) -> Iterator[FollowedFrame]:
    """Yield every frame with its detections and estimates; frames are taken one at a time.

    The detector is given the tracker's prediction, None before its start. This function owns the
    tracker's state: nothing else calls `start`, `step` and `predict`.
    Raises what the frames, the detector or the tracker raise; a PlugInFault names the frame.
    """
    state: State | None = None
    previous_s: float | None = None
    source = iter(frames)
    while True:
        started = time.perf_counter()
        frame = next(source, None)
        if frame is None:
            return
        rendered = time.perf_counter()
        dt_s = 0.0 if previous_s is None else frame.time_s - previous_s
        previous_s = frame.time_s
        try:
            expected = None if state is None else tracker.predict(state, dt_s)
            predicted = time.perf_counter()
            detections = detector(frame, expected)
            detected = time.perf_counter()
            if state is None:
                state = tracker.start(detections)
                estimates = Estimates.waiting() if state is None else tracker.estimates(state)
            else:
                state, estimates = tracker.step(state, detections, dt_s)
        except PlugInFault as fault:
            raise PlugInFault(f"frame {frame.index}: {fault}") from fault
        tracked = time.perf_counter()
        yield FollowedFrame(
            frame,
            detections,
            estimates,
            dt_s,
            render_s=rendered - started,
            detect_s=detected - predicted,
            track_s=predicted - rendered + tracked - detected,
        )
