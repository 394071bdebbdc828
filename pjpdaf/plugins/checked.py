"""A detector or tracker of somebody else's, every answer of which is checked before it is used.

What is wrong names the plug-in, the method and what it gave, in one line.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

from pjpdaf.errors import PlugInFault
from pjpdaf.frames import StereoFrame
from pjpdaf.interfaces import AnyTracker, Detections, Detector, Estimates
from pjpdaf.plugins.conformance import fault_of_detections, fault_of_estimates, fault_of_step
from pjpdaf.plugins.registry import described


@dataclass(frozen=True)
class CheckedTracker:
    """A `Tracker`, named in its faults; every method raises PlugInFault."""

    name: str
    tracker: AnyTracker

    def start(self, seen: tuple[Detections, ...]) -> Any:
        """A first state, which may be anything: only the tracker reads it."""
        return _asked(self.name, "start", self.tracker.start, seen)

    def step(self, state: Any, seen: tuple[Detections, ...], dt_s: float) -> tuple[Any, Estimates]:
        """A state, and estimates that can be scored."""
        result = _asked(self.name, "step", self.tracker.step, state, seen, dt_s)
        _refuse(self.name, "step", fault_of_step(result))
        after, said = result
        return after, said

    def estimates(self, state: Any) -> Estimates:
        """Estimates that can be scored."""
        return self._said("estimates", self.tracker.estimates, state)

    def predict(self, state: Any, dt_s: float) -> Estimates:
        """Estimates, as of the other methods."""
        return self._said("predict", self.tracker.predict, state, dt_s)

    def _said(self, what: str, method: Callable[..., Estimates], *arguments: Any) -> Estimates:
        said = _asked(self.name, what, method, *arguments)
        _refuse(self.name, what, fault_of_estimates(said))
        estimates: Estimates = said
        return estimates


@dataclass(frozen=True)
class CheckedDetector:
    """A `Detector`, as `CheckedTracker`. views: how many cameras there are."""

    name: str
    detector: Detector
    views: int

    def learn(self, background: Iterable[StereoFrame]) -> CheckedDetector:
        """A detector that is checked, too."""
        learnt = _asked(self.name, "learn", self.detector.learn, background)
        if not callable(learnt):
            given = type(learnt).__name__
            raise PlugInFault(f"{self.name}: learn: must return a detector, returns {given}")
        return CheckedDetector(self.name, learnt, self.views)

    def __call__(
        self, frame: StereoFrame, predicted: Estimates | None = None
    ) -> tuple[Detections, ...]:
        """Finite detections of all views."""
        seen = _asked(self.name, "call", self.detector, frame, predicted)
        _refuse(self.name, "call", fault_of_detections(seen, self.views))
        detections: tuple[Detections, ...] = seen
        return detections


def _asked(name: str, what: str, method: Callable[..., Any], *arguments: Any) -> Any:
    try:
        return method(*arguments)
    except (Exception, SystemExit) as fault:
        raise PlugInFault(f"{name}: {what}: raises {described(fault)}") from fault


def _refuse(name: str, what: str, fault: str) -> None:
    if fault:
        raise PlugInFault(f"{name}: {what}: {fault}")
