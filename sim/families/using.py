"""Cues of an object that is taken, used and put back."""

from __future__ import annotations

from sim.motion.motion import Cue, Hold, successive


def use(
    hold: Hold, begun_s: float, brought: tuple[str, float], used: tuple[str, float]
) -> tuple[Cue, ...]:
    """Cues of reaching from begun_s [s] on, bringing, using and putting back.

    brought, used: name and end [s] of a cue.
    """
    return successive(begun_s, ("reach", hold.from_s), brought, used, ("put_back", hold.to_s))
