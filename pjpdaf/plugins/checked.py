"""A user's detector or tracker, every answer of which is checked before it is used.

A fault names the plug-in, the method and the answer, in one line.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

from pjpdaf.errors import PlugInFault
from pjpdaf.frames import StereoFrame
from pjpdaf.interfaces import AnyTracker, Detections, Detector, Estimates, Smoother
from pjpdaf.known_targets import KnownTargets
from pjpdaf.plugins.answers import fault_of_detections, fault_of_estimates, fault_of_step
from pjpdaf.plugins.loading import describe_exception


@dataclass(frozen=True)
class CheckedTracker:
    """A `Tracker`, named in its faults; every method raises PlugInFault."""

    name: str
    tracker: AnyTracker

    def start(self, detections: tuple[Detections, ...]) -> Any:
        """Return the first state, which may be anything: only the tracker reads it."""
        return _call(self.name, "start", self.tracker.start, detections)

    def step(
        self, state: Any, detections: tuple[Detections, ...], dt_s: float
    ) -> tuple[Any, Estimates]:
        """Return a state, and estimates that can be scored."""
        answer = _call(self.name, "step", self.tracker.step, state, detections, dt_s)
        _refuse(self.name, "step", fault_of_step(answer))
        after, estimates = answer
        return after, estimates

    def step_associated(
        self, state: Any, detections: tuple[Detections, ...], known: KnownTargets, dt_s: float
    ) -> tuple[Any, Estimates]:
        """Return a state and estimates, of a tracker whose association can be replaced."""
        method = "step_associated"
        answer = _call(
            self.name, method, getattr(self.tracker, method), state, detections, known, dt_s
        )
        _refuse(self.name, method, fault_of_step(answer))
        after, estimates = answer
        return after, estimates

    def expecting(self, state: Any, known: KnownTargets, dt_s: float) -> Any:
        """Return a state, of a tracker whose prediction can be replaced."""
        method = "expecting"
        return _call(self.name, method, getattr(self.tracker, method), state, known, dt_s)

    def estimates(self, state: Any) -> Estimates:
        """Return estimates that can be scored."""
        return self._estimates("estimates", self.tracker.estimates, state)

    def predict(self, state: Any, dt_s: float) -> Estimates:
        """Return a prediction, checked as estimates are."""
        return self._estimates("predict", self.tracker.predict, state, dt_s)

    def _estimates(self, label: str, method: Callable[..., Any], *arguments: Any) -> Estimates:
        answer = _call(self.name, label, method, *arguments)
        _refuse(self.name, label, fault_of_estimates(answer))
        estimates: Estimates = answer
        return estimates


class CheckedSmoother(CheckedTracker):
    """A checked tracker that is a `Smoother`."""

    def smoothed(self, states: tuple[Any, ...]) -> Estimates:
        """Return estimates that can be scored."""
        return self._estimates("smoothed", self.tracker.smoothed, states)  # type: ignore[attr-defined]


def checked_tracker(name: str, tracker: AnyTracker) -> CheckedTracker:
    """A tracker whose answers are checked; a `Smoother` where it is one."""
    kind = CheckedSmoother if isinstance(tracker, Smoother) else CheckedTracker
    return kind(name, tracker)


@dataclass(frozen=True)
class CheckedDetector:
    """A `Detector`, named in its faults; methods raise PlugInFault. views: number of cameras."""

    name: str
    detector: Detector
    views: int

    def learn(self, background: Iterable[StereoFrame]) -> CheckedDetector:
        """Return a detector that is checked, too."""
        learnt = _call(self.name, "learn", self.detector.learn, background)
        if not callable(learnt):
            given = type(learnt).__name__
            raise PlugInFault(f"{self.name}: learn: must return a detector, returns {given}")
        return CheckedDetector(self.name, learnt, self.views)

    def __call__(
        self, frame: StereoFrame, predicted: Estimates | None = None
    ) -> tuple[Detections, ...]:
        """Return finite detections of all views."""
        answer = _call(self.name, "call", self.detector, frame, predicted)
        _refuse(self.name, "call", fault_of_detections(answer, self.views))
        detections: tuple[Detections, ...] = answer
        return detections


def _call(name: str, label: str, method: Callable[..., Any], *arguments: Any) -> Any:
    try:
        return method(*arguments)
    except (Exception, SystemExit) as fault:
        raise PlugInFault(f"{name}: {label}: raises {describe_exception(fault)}") from fault


def _refuse(name: str, label: str, fault: str) -> None:
    if fault:
        raise PlugInFault(f"{name}: {label}: {fault}")
