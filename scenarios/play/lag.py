"""The lag of estimates: its range, and whether a tracker knows how to look back."""

from __future__ import annotations

from pjpdaf.camera import Camera
from pjpdaf.errors import BenchError
from pjpdaf.interfaces import AnyTracker, Smoother
from pjpdaf.plugins.registry import make_tracker
from scenarios.play.job import System

MAX_LAG = 60  # frames are held so long


def check_lag(lag: int) -> None:
    """Raise BenchError for a lag that is out of range."""
    if not 0 <= lag <= MAX_LAG:
        raise BenchError(f"--lag must be from 0 to {MAX_LAG} frames, got {lag}")


def make_lagged(system: System, cameras: tuple[Camera, ...]) -> AnyTracker:
    """Make the tracker of a system. Raises BenchError where it cannot give the system's lag."""
    tracker = make_tracker(system.tracker, cameras, system.tracker_settings)
    check_smoother(system.tracker, tracker, system.lag)
    return tracker


def check_smoother(name: str, tracker: AnyTracker, lag: int) -> None:
    """Raise BenchError for a lag with a tracker that cannot look back; name: the tracker's."""
    if lag and not isinstance(tracker, Smoother):
        raise BenchError(
            f"--lag {lag}: the tracker {name!r} does not look back: it has no method `smoothed`; "
            "leave --lag out, or take the tracker 'default'"
        )
