"""Which stage is at fault for a swap or a loss: the first whose replacement by truth cures it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from pjpdaf.camera import Camera
from pjpdaf.interfaces import AnyTracker
from reports.score.events import Event, find_events
from reports.score.records import Episode
from scenarios.play.oracle import Oracle, Seen, stages_of, track_again

BLAMED = ("swap", "capture", "lost")  # a recovery is nobody's fault
NONE = "none"  # no single replacement cures it


def with_blame(
    episode: Episode,
    cameras: Sequence[Camera],
    tracker: AnyTracker,
    seen: Seen | None = None,
    lag: int = 0,
) -> Episode:
    """The episode with the stage at fault for each of its swaps, captures and losses.

    seen, lag: as `track_again`.
    """
    return replace(episode, blame=blame(episode, cameras, tracker, seen, lag))


def blame(
    episode: Episode,
    cameras: Sequence[Camera],
    tracker: AnyTracker,
    seen: Seen | None = None,
    lag: int = 0,
) -> Mapping[tuple[str, int, int], str]:
    """The stage at fault, or NONE, for (kind, target, first frame) of each swap, capture and loss.

    The stages are tried in the order of `scenarios.play.oracle.STAGES`. Cured: no event of the same
    kind and target overlaps its frames. lag: of the episode's estimates.
    """
    failures = [event for event in find_events(episode) if event.kind in BLAMED]
    stages: dict[tuple[str, int, int], str] = {}
    for stage in stages_of(tracker):
        if len(stages) == len({(e.kind, e.target, e.first) for e in failures}):
            break  # nothing is left to be cured
        again = track_again(episode, cameras, tracker, Oracle(**{stage: True}), seen, lag)
        remaining = find_events(again)
        for event in failures:
            key = (event.kind, event.target, event.first)
            if key not in stages and not any(_same(event, other) for other in remaining):
                stages[key] = stage
    return {
        (e.kind, e.target, e.first): stages.get((e.kind, e.target, e.first), NONE) for e in failures
    }


def _same(event: Event, other: Event) -> bool:
    overlap = other.first <= event.last and event.first <= other.last
    return overlap and (other.kind, other.target) == (event.kind, event.target)
