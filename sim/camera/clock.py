"""Times at which pictures are taken, their time stamps, and the pictures that arrive."""

from __future__ import annotations

from dataclasses import dataclass

from sim.randomness import generator
from sim.specs import ClockSpec

MOST_OF_PERIOD = 0.45  # jitter stays below half the time between frames, so that they keep order


@dataclass(frozen=True)
class Moment:
    """Times of a frame. time_s: when it is taken; stamp_s: the time that it carries [s];
    arrived: per view, whether its picture does.
    """

    time_s: float
    stamp_s: float
    arrived: tuple[bool, ...]


def moment(clock: ClockSpec, fps: float, seed: int, index: int, views: tuple[str, ...]) -> Moment:
    """The times of a frame: index / fps with jitter, the same for all views, never before 0.

    The jitter is uniform within jitter_s, or within MOST_OF_PERIOD of the time between frames where
    that is less. All draws are addressed by (seed, frame), losses by the view as well: a frame
    can be drawn without the others, and a view is lost without the other.
    """
    nominal_s = index / fps
    reach_s = min(clock.jitter_s, MOST_OF_PERIOD / fps)
    share = generator(seed, "clock/jitter", index).uniform(-1.0, 1.0) if reach_s > 0 else 0.0
    time_s = max(nominal_s + reach_s * share, 0.0)
    arrived = tuple(
        generator(seed, f"clock/dropped/{view}", index).random() >= clock.dropped for view in views
    )
    return Moment(time_s, nominal_s if clock.stamps == "nominal" else time_s, arrived)
