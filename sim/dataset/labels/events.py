"""What happens in a sequence, as intervals of frames: merges, contacts, who hides whom."""

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

    merges: two targets' visible skin is one blob in a view; splits: the first frame after one.
    ambiguous: both hands are one blob in every view, so that no picture tells them apart.
    occlusions: at least LEAST_HIDDEN of a target is hidden by an instance in a view; peak_share is
    the most. script: what the motion itself says (contact, grasp, phases of a stroke).
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
    found = []
    for t, target in enumerate(TARGETS):
        whole = np.array([max(truth.views[view].amodal_px[t], 1) for truth in truths])
        for one in instances.table:
            shares = np.array([frame[view][t][one.id] for frame in hidden]) / whole
            for first, last in _spans((shares >= LEAST_HIDDEN).tolist()):
                peak = float(shares[first : last + 1].max())
                found.append(
                    {
                        "view": CAMERAS[view],
                        "target": target,
                        "by": one.name,
                        **_ends((first, last)),
                        "peak_share": round(peak, 4),
                    }
                )
    return found


def _spans(holds: Iterable[bool]) -> list[tuple[int, int]]:
    """First and last of each run of frames in which something holds."""
    spans: list[tuple[int, int]] = []
    for index, it_does in enumerate(holds):
        if not it_does:
            continue
        if spans and spans[-1][1] == index - 1:
            spans[-1] = spans[-1][0], index
        else:
            spans.append((index, index))
    return spans


def _ends(span: tuple[int, int]) -> dict[str, int]:
    return {"first_frame": span[0], "last_frame": span[1]}
