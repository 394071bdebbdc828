"""Measures a performance: is it a motion that a person could make?"""

from __future__ import annotations

from collections.abc import Iterable

from sim.contact import Unposable
from sim.motion import Performer


def fault_of(performer: Performer, times_s: Iterable[float]) -> str | None:
    """Why the performer cannot be shown at these times, None where all is well."""
    try:
        for t_s in times_s:
            performer.body(t_s)
    except Unposable as fault:
        return str(fault)
    return None
