"""events.json against the rows of the tables that it sums up, frame by frame."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from itertools import combinations
from typing import Any

from pjpdaf.targets import LEFT_HAND, RIGHT_HAND, TARGETS
from sim.dataset.check.fault import Fault, FrameFault
from sim.dataset.check.frame_tables import FrameTables
from sim.dataset.files.layout import EVENTS
from sim.dataset.labels.events import LEAST_HIDDEN
from sim.scene.world import CAMERAS

FrameEvents = set[tuple[int, str]]  # frame index, name of the event
_KINDS = ("merges", "splits", "ambiguous", "occlusions", "script")
_BOTH_HANDS = "both hands"


def check_events(
    name: str, tables: list[FrameTables], events: Mapping[str, Any]
) -> Iterator[Fault | FrameFault]:
    """Compare the intervals of events.json with the events in the rows of a sequence."""
    file = f"{name}/{EVENTS}"
    try:
        listed = {kind: _listed(kind, events[kind], len(tables)) for kind in _KINDS}
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        yield Fault(file, f"is not lists of intervals of {len(tables)} frames: {error!r}")
        return
    for kind, computed in _computed(tables).items():
        for frame, event in sorted(listed[kind] - computed):
            yield FrameFault(file, kind, frame, f"{event}: the truth's rows do not say so")
        for frame, event in sorted(computed - listed[kind]):
            yield FrameFault(file, kind, frame, f"{event}: missing")


def _listed(kind: str, intervals: Iterable[Mapping[str, Any]], frames: int) -> FrameEvents:
    """The events of a list of events.json. Raises ValueError for an interval that is not."""
    events: FrameEvents = set()
    for interval in intervals:
        if kind == "splits":
            first = last = interval["frame_index"]
        else:
            first, last = interval["first_frame"], interval["last_frame"]
        if not 0 <= first <= last < frames:
            raise ValueError(f"{kind}: frames {first} to {last}")
        events |= {(frame, _name(kind, interval)) for frame in range(first, last + 1)}
    return events


def _name(kind: str, interval: Mapping[str, Any]) -> str:
    if kind in ("merges", "splits"):
        return f"{interval['view']} {'+'.join(interval['targets'])}"
    if kind == "occlusions":
        return f"{interval['view']} {interval['target']} by {interval['by']}"
    return str(interval["event"]) if kind == "script" else _BOTH_HANDS


def _computed(tables: list[FrameTables]) -> dict[str, FrameEvents]:
    """The events of each kind that the rows of the tables show."""
    events: dict[str, FrameEvents] = {kind: set() for kind in _KINDS}
    for i, frame in enumerate(tables):
        views = frame.truth.views
        for view, camera in enumerate(CAMERAS):
            for a, b in combinations(range(len(TARGETS)), 2):
                pair = f"{camera} {TARGETS[a]}+{TARGETS[b]}"
                if views[view].merged[a, b]:
                    events["merges"].add((i, pair))
                elif i > 0 and tables[i - 1].truth.views[view].merged[a, b]:
                    events["splits"].add((i, pair))
            for t, row in enumerate(frame.rows):
                amodal_px = max(int(views[view].amodal_px[t]), 1)
                for by in row[f"occluded_by_{camera}"]:
                    if by["pixels"] / amodal_px >= LEAST_HIDDEN and by["instance"] != "nothing":
                        name = f"{camera} {TARGETS[t]} by {by['instance']}"
                        events["occlusions"].add((i, name))
        if all(view.merged[RIGHT_HAND, LEFT_HAND] for view in views):
            events["ambiguous"].add((i, _BOTH_HANDS))
        events["script"] |= {(i, event) for event in frame.truth.script_events}
    return events
