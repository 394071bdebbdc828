"""events.json against the rows that it sums up, frame by frame."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from itertools import combinations
from typing import Any

from pjpdaf.targets import LEFT_HAND, RIGHT_HAND, TARGETS
from sim.dataset.check.fault import Claim, Fault
from sim.dataset.check.frame_tables import FrameTables
from sim.dataset.files.layout import EVENTS
from sim.dataset.labels.events import LEAST_HIDDEN
from sim.scene.world import CAMERAS

Facts = set[tuple[int, str]]  # frame, what happens in it


def event_faults(
    name: str, told: list[FrameTables], events: Mapping[str, Any]
) -> Iterator[Claim | Fault]:
    """What events.json says that the rows do not, and the other way round."""
    file = f"{name}/{EVENTS}"
    try:
        said = {kind: _said(kind, events[kind], len(told)) for kind in _KINDS}
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        yield Fault(file, f"is not lists of intervals of {len(told)} frames: {error!r}")
        return
    for kind, found in _found(told).items():
        for frame, what in sorted(said[kind] - found):
            yield Claim(file, kind, frame, f"{what}: the truth's rows do not say so")
        for frame, what in sorted(found - said[kind]):
            yield Claim(file, kind, frame, f"{what}: missing")


_KINDS = ("merges", "splits", "ambiguous", "occlusions", "script")


def _said(kind: str, listed: Iterable[Mapping[str, Any]], frames: int) -> Facts:
    facts: Facts = set()
    for one in listed:
        if kind == "splits":
            first = last = one["frame_index"]
        else:
            first, last = one["first_frame"], one["last_frame"]
        if not 0 <= first <= last < frames:
            raise ValueError(f"{kind}: frames {first} to {last}")
        facts |= {(frame, _name(kind, one)) for frame in range(first, last + 1)}
    return facts


def _name(kind: str, one: Mapping[str, Any]) -> str:
    if kind in ("merges", "splits"):
        return f"{one['view']} {'+'.join(one['targets'])}"
    if kind == "occlusions":
        return f"{one['view']} {one['target']} by {one['by']}"
    return str(one["event"]) if kind == "script" else "both hands"


def _found(told: list[FrameTables]) -> dict[str, Facts]:
    facts: dict[str, Facts] = {kind: set() for kind in _KINDS}
    for i, frame in enumerate(told):
        views = frame.truth.views
        for view, camera in enumerate(CAMERAS):
            for a, b in combinations(range(len(TARGETS)), 2):
                what = f"{camera} {TARGETS[a]}+{TARGETS[b]}"
                if views[view].merged[a, b]:
                    facts["merges"].add((i, what))
                elif i > 0 and told[i - 1].truth.views[view].merged[a, b]:
                    facts["splits"].add((i, what))
            for t, row in enumerate(frame.rows):
                whole = max(int(views[view].amodal_px[t]), 1)
                for one in row[f"occluded_by_{camera}"]:
                    if one["pixels"] / whole >= LEAST_HIDDEN and one["instance"] != "nothing":
                        what = f"{camera} {TARGETS[t]} by {one['instance']}"
                        facts["occlusions"].add((i, what))
        if all(view.merged[RIGHT_HAND, LEFT_HAND] for view in views):
            facts["ambiguous"].add((i, "both hands"))
        facts["script"] |= {(i, event) for event in frame.truth.script_events}
    return facts
