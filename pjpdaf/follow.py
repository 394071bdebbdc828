"""The loop that follows a person through frames: detector and tracker, a frame at a time."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

from pjpdaf.errors import BenchError, PlugInFault
from pjpdaf.frames import StereoFrame
from pjpdaf.interfaces import Detections, Detector, Estimates, Smoother, Tracker

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
    frames: Iterable[StereoFrame], detector: Detector, tracker: Tracker[State], lag: int = 0
) -> Iterator[FollowedFrame]:
    """Yield every frame with its detections and estimates; frames are taken one at a time.

    The detector is given the tracker's prediction, None before its start. This function owns the
    tracker's state: nothing else calls `start`, `step` and `predict`.
    lag: a frame is yielded only so many frames later, with the estimates that a tracker which is a
    `Smoother` then gives of it; the last frames in the knowledge of all that there are.
    Raises what the frames, the detector or the tracker raise, after the frames before it; a
    PlugInFault names the frame. ValueError for a lag of a tracker that is no `Smoother`.
    """
    steps = _filtered(frames, detector, tracker)
    if lag == 0:
        yield from (step for step, _ in steps)
        return
    if not isinstance(tracker, Smoother):
        raise ValueError("a lag needs a tracker that is a Smoother")
    held: deque[tuple[FollowedFrame, State | None]] = deque()
    ended: Exception | None = None
    try:
        for step in steps:
            held.append(step)
            if len(held) > lag:
                yield _smoothed(held, tracker)
                held.popleft()
    except (BenchError, PlugInFault) as fault:
        ended = fault
    while held:
        yield _smoothed(held, tracker)
        held.popleft()
    if ended is not None:
        raise ended


def _smoothed(
    held: Sequence[tuple[FollowedFrame, State | None]], smoother: Smoother[State]
) -> FollowedFrame:
    """The first of the frames held, its estimates in the knowledge of the others."""
    step = held[0][0]
    states = tuple(state for _, state in held if state is not None)
    if held[0][1] is None or len(states) == 1:
        return step
    started = time.perf_counter()
    try:
        estimates = smoother.smoothed(states)
    except PlugInFault as fault:
        raise PlugInFault(f"frame {step.frame.index}: {fault}") from fault
    track_s = step.track_s + time.perf_counter() - started
    return replace(step, estimates=estimates, track_s=track_s)


def _filtered(
    frames: Iterable[StereoFrame], detector: Detector, tracker: Tracker[State]
) -> Iterator[tuple[FollowedFrame, State | None]]:
    """Yield every frame, and the tracker's state after it, None before its start."""
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
        followed = FollowedFrame(
            frame,
            detections,
            estimates,
            dt_s,
            render_s=rendered - started,
            detect_s=detected - predicted,
            track_s=predicted - rendered + tracked - detected,
        )
        yield followed, state
