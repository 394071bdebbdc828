"""Conformance of a user's detector or tracker to the protocols of `pjpdaf.interfaces`.

The scenes are our own: three targets in front of two cameras, as measurements for a tracker, as
painted pictures for a detector. Every fault is one line: the call, then the fault.
"""

from __future__ import annotations

from functools import partial

from pjpdaf.errors import BenchError
from pjpdaf.plugins import detector_check, tracker_check
from pjpdaf.plugins.probe import Probe
from pjpdaf.plugins.registry import Factory, make_detector, make_tracker

LIMIT_S = 10.0
LONGEST_LIMIT_S = 3600.0


def check_named(kind: str, name: str, limit_s: float = LIMIT_S) -> tuple[str, ...]:
    """Check a plug-in by name: an entry point, or module:factory. kind: tracker, detector.

    Motions are checked by `scenarios.catalogue.motion_check`, which has a scene to play them in.

    Raises BenchError for another kind, NoSuchPlugIn for a name that is not there.
    """
    if kind not in ("tracker", "detector"):
        raise BenchError(f"--kind must be tracker, detector or motion, got {kind!r}")
    check_limit(limit_s)
    if kind == "tracker":
        return check_tracker(partial(make_tracker, name), limit_s)
    return check_detector(partial(make_detector, name), limit_s)


def check_limit(limit_s: float) -> None:
    """Raise BenchError for a time limit that is none."""
    if not 0 < limit_s <= LONGEST_LIMIT_S:
        raise BenchError(
            f"--limit must be above 0 and at most {LONGEST_LIMIT_S:g} s, got {limit_s:g}"
        )


def check_tracker(factory: Factory, limit_s: float = LIMIT_S) -> tuple[str, ...]:
    """Check a tracker; returns all faults, none where it keeps to the protocol.

    limit_s: time that a call may take [s]. A call that hangs leaves its thread behind.
    """
    return Probe(limit_s).run(partial(tracker_check.check, factory))


def check_detector(factory: Factory, limit_s: float = LIMIT_S) -> tuple[str, ...]:
    """Check a detector, as `check_tracker`."""
    return Probe(limit_s).run(partial(detector_check.check, factory))
