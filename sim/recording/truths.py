"""Truth and times of frames as plain bytes of fixed size, and back, bit for bit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pjpdaf.targets import TARGETS
from sim.scene.world import CAMERAS
from sim.truth import Truth, ViewTruth

_T, _V = len(TARGETS), len(CAMERAS)
_VIEW = np.dtype(
    [
        ("centroids_px", "<f8", (_T, 2)),
        ("visible_px", "<i8", (_T,)),
        ("amodal_px", "<i8", (_T,)),
        ("boxes_px", "<f8", (_T, 4)),
        ("merged", "u1", (_T, _T)),
    ]
)
FRAME = np.dtype(
    [
        ("time_s", "<f8"),
        ("stamp_s", "<f8"),
        ("arrived", "u1", (_V,)),
        ("centres_m", "<f8", (_T, 3)),
        ("velocities_mps", "<f8", (_T, 3)),
        ("surfaces_m", "<f8", (_T, 3)),
        ("views", _VIEW, (_V,)),
    ]
)


@dataclass(frozen=True, eq=False)
class FrameFacts:
    """What is known of a frame beside its pictures.

    stamp_s: the time that the frame carries [s]; arrived: per view, whether its picture did.
    """

    truth: Truth
    stamp_s: float
    arrived: tuple[bool, ...]


def facts_to_bytes(frames: Sequence[FrameFacts]) -> bytes:
    """The frames as `FRAME` records; the names of events are not in them."""
    records = np.zeros(len(frames), FRAME)
    for record, facts in zip(records, frames, strict=True):
        truth = facts.truth
        record["time_s"], record["stamp_s"] = truth.time_s, facts.stamp_s
        record["arrived"] = facts.arrived
        for name in ("centres_m", "velocities_mps", "surfaces_m"):
            record[name] = getattr(truth, name)
        for stored, view in zip(record["views"], truth.views, strict=True):
            for name in _VIEW.names or ():
                stored[name] = getattr(view, name)
    return records.tobytes()


def facts_from_bytes(data: bytes, events: Sequence[Sequence[str]]) -> tuple[FrameFacts, ...]:
    """Inverse of `facts_to_bytes`. events: the names of each frame's.

    Raises ValueError where the bytes are not of as many frames.
    """
    if len(data) != FRAME.itemsize * len(events):
        raise ValueError(f"must have {FRAME.itemsize} bytes a frame")
    records = np.frombuffer(data, FRAME)
    return tuple(
        FrameFacts(
            truth=Truth(
                index=index,
                time_s=float(record["time_s"]),
                centres_m=record["centres_m"],
                velocities_mps=record["velocities_mps"],
                surfaces_m=record["surfaces_m"],
                views=tuple(
                    ViewTruth(**{name: view[name] for name in _VIEW.names or ()})
                    for view in record["views"]
                ),
                events=tuple(names),
            ),
            stamp_s=float(record["stamp_s"]),
            arrived=tuple(bool(arrived) for arrived in record["arrived"]),
        )
        for index, (record, names) in enumerate(zip(records, events, strict=True))
    )
