"""Names of events that carry facts: the pair of a merge, the speed of a stroke."""

from __future__ import annotations

import math

_MERGE, _SPEED = "merge:", "speed:"


def merge_name(target: str, other: str, camera: str) -> str:
    """Name of the merge of two targets in a camera's view."""
    return f"{_MERGE}{target}+{other}:{camera}_view"


def is_merge(name: str) -> bool:
    """Whether a name is that of a merge."""
    return name.startswith(_MERGE)


def speed_name(speed_mps: float) -> str:
    """Name of a stroke of this speed [m/s]."""
    return f"{_SPEED}{speed_mps:g}"


def stroke_speed_mps(name: str) -> float:
    """Speed [m/s] of a stroke from its name, NaN for any other event."""
    try:
        speed_mps = float(name.removeprefix(_SPEED)) if name.startswith(_SPEED) else math.nan
    except ValueError:
        return math.nan
    return speed_mps if speed_mps > 0 else math.nan
