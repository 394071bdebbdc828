"""Events of a sequence as intervals of frames: merges, splits, occlusions, phases of motion."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import combinations
from typing import Any

import numpy as np

from pjpdaf.targets import LEFT_HAND, RIGHT_HAND, TARGETS
from sim.dataset.labels.instances import Instances
from sim.scene.world import CAMERAS
from sim.truth import Truth

LEAST_HIDDEN = 0.05  # share of the amodal target; less is a touch of silhouettes


def events_of(
    truths: Sequence[Truth], hidden: Sequence[Sequence[Any]], instances: Instances
) -> dict[str, Any]:
    """The content of `events.json`: lists of intervals of frame indices, both ends included.

    merges: the visible skin of two targets is one blob in a view; splits: the first frame after a
    merge.
    ambiguous: both hands are one blob in every view, so that no picture separates them.
    occlusions: at least LEAST_HIDDEN of a target is hidden by an instance in a view; peak_share is
    the maximum. script: events of the motion itself (contact, grasp, phases of a stroke).
    hidden: per frame and view, `ViewLabels.hidden_px` (T, I).
    """
    merges, splits, occlusions = [], [], []
    for view, camera in enumerate(CAMERAS):
        for a, b in combinations(range(len(TARGETS)), 2):
            names = [TARGETS[a], TARGETS[b]]
            spans = _spans(bool(truth.views[view].merged[a, b]) for truth in truths)
            merges += [{"view": camera, "targets": names, **_ends(s)} for s in spans]
            splits += [
                {"view": camera, "targets": names, "frame_index": last + 1}
                for _, last in spans
                if last + 1 < len(truths)
            ]
        occlusions += _occlusions(truths, hidden, instances, view)
    hands = RIGHT_HAND, LEFT_HAND
    ambiguous = _spans(all(v.merged[hands] for v in truth.views) for truth in truths)
    named = sorted({event for truth in truths for event in truth.script_events})
    script = [
        {"event": name, **_ends(span)}
        for name in named
        for span in _spans(name in truth.events for truth in truths)
    ]
    return {
        "merges": merges,
        "splits": splits,
        "ambiguous": [_ends(span) for span in ambiguous],
        "occlusions": occlusions,
        "script": script,
    }


def _occlusions(
    truths: Sequence[Truth], hidden: Sequence[Sequence[Any]], instances: Instances, view: int
) -> list[dict[str, Any]]:
    occlusions = []
    for t, target in enumerate(TARGETS):
        whole = np.array([max(truth.views[view].amodal_px[t], 1) for truth in truths])
        for instance in instances.table:
            shares = np.array([frame[view][t][instance.id] for frame in hidden]) / whole
            for first, last in _spans((shares >= LEAST_HIDDEN).tolist()):
                peak = float(shares[first : last + 1].max())
                occlusions.append(
                    {
                        "view": CAMERAS[view],
                        "target": target,
                        "by": instance.name,
                        **_ends((first, last)),
                        "peak_share": round(peak, 4),
                    }
                )
    return occlusions


def _spans(holds: Iterable[bool]) -> list[tuple[int, int]]:
    """First and last frame of each run of frames where `holds` is true."""
    spans: list[tuple[int, int]] = []
    for index, is_true in enumerate(holds):
        if not is_true:
            continue
        if spans and spans[-1][1] == index - 1:
            spans[-1] = spans[-1][0], index
        else:
            spans.append((index, index))
    return spans


def _ends(span: tuple[int, int]) -> dict[str, int]:
    return {"first_frame": span[0], "last_frame": span[1]}
