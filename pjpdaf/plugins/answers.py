"""Faults of the answers of a detector or tracker: why they cannot be used or scored."""

from __future__ import annotations

import numpy as np

from pjpdaf.interfaces import Detections, Estimates
from pjpdaf.targets import TARGETS

FARTHEST_M = 1e6  # beyond this is no place, but a filter that has diverged


def fault_of_estimates(answer: object) -> str:
    """Reason why this cannot be scored, or "": no `Estimates`, other targets, infinite numbers.

    NaN is a target without a place, and scored as missed.
    """
    if not isinstance(answer, Estimates):
        return f"must give an Estimates, gives {type(answer).__name__}"
    count = len(answer.status)
    if count != len(TARGETS):
        return f"must have {len(TARGETS)} targets ({', '.join(TARGETS)}), has {count}"
    for name in ("positions_m", "covariances_m2", "velocities_mps"):
        if np.isinf(getattr(answer, name)).any():
            return f"{name} has infinite values"
    farthest_m = np.nanmax(np.abs(answer.positions_m), initial=0.0)
    if farthest_m > FARTHEST_M:
        return f"positions_m has a value of {farthest_m:.2g} m; they are in the world, in metres"
    return ""


def fault_of_step(answer: object) -> str:
    """Reason why the (state, Estimates) of a tracker's `step` cannot be used, or ""."""
    if not (isinstance(answer, tuple) and len(answer) == 2):
        return f"must return (state, Estimates), returns {_type_name(answer)}"
    if answer[0] is None:
        return "must return a state, returns None"
    return fault_of_estimates(answer[1])


def fault_of_detections(answer: object, views: int) -> str:
    """Reason why a tracker cannot be given this, or "". views: number of cameras."""
    if not (isinstance(answer, tuple) and all(isinstance(view, Detections) for view in answer)):
        return f"must give a tuple of Detections, gives {_type_name(answer)}"
    if len(answer) != views:
        return f"must give {views} views, gives {len(answer)}"
    for view in answer:
        for name in ("centres_px", "covariances_px2", "ellipses", "areas_px"):
            if not np.isfinite(getattr(view, name)).all():
                return f"{name} has NaN or infinite values"
        if view.evidence is not None and view.evidence.shape[1] != len(TARGETS):
            return (
                f"evidence must have a column for each of {len(TARGETS)} targets "
                f"({', '.join(TARGETS)}), has {view.evidence.shape[1]}"
            )
    return ""


def _type_name(value: object) -> str:
    if not isinstance(value, tuple):
        return type(value).__name__
    return f"({', '.join(type(member).__name__ for member in value[:5])})"
