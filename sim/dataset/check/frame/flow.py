"""Optical flow between two frames: against the poses of truth.parquet, and forward and back."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from scipy.spatial.transform import Rotation

from pjpdaf.arrays import Floats
from pjpdaf.targets import HEAD, TARGETS
from sim.dataset.check.fault import Fault
from sim.dataset.check.frame.arrays import present
from sim.dataset.check.frame.correspondence import REACH_PX
from sim.dataset.check.frame.disparity import LEAST_RIGHT
from sim.dataset.check.frame.pixel_rays import (
    CLOSES_PX,
    HOME_PX,
    PixelIndex,
    corners,
    inside,
    most,
    off_home,
    positions,
    select,
    straight,
)
from sim.dataset.check.frame.view import FEW, FrameView, is_static
from sim.dataset.check.frame_tables import FrameTables, rotation_of
from sim.dataset.files.layout import DEPTH_UNIT_M, FLOW_SCALE
from sim.dataset.labels.instances import FIRST_OBJECT
from sim.dataset.labels.records import NO_SURFACE, OUT_OF_FRAME, SEEN, Matches

STEP = 2  # every STEP-th pixel of every STEP-th row is compared
LEAST_CLOSED = 0.95  # of 58 flows in varied rooms, 160 x 120 pixels and more, all did
Move = Callable[[Floats], Floats]


def check_flow(
    here: FrameView, there: FrameView, tables: tuple[FrameTables, FrameTables] | None, label: str
) -> Iterator[Fault]:
    """Check the flow of a view's frame to that of another, and back; the first fault.

    label: "flow_forward" or "flow_backward", of the frame `here`; tables: of both frames. Both
    have ids and depth without fault.
    """
    forward = label == "flow_forward"
    own = here.own.forward if forward else here.own.backward
    back = there.own.backward if forward else there.own.forward
    matches, file = present(own), here.file(label)
    if int(matches.status.max()) > OUT_OF_FRAME:
        known = f"known are 0 to {OUT_OF_FRAME}"
        yield Fault(file, f"has the status {int(matches.status.max())}; {known}")
        return
    at = here.rays.grid(STEP)
    seg = present(here.own.seg)
    moved_px = np.linalg.norm(_moved(matches, at), axis=1)
    still = is_static(seg[at]) & (matches.status[at] != NO_SURFACE)
    moving = int(np.count_nonzero(moved_px[still] > 0.5 / FLOW_SCALE))
    if moving:
        yield Fault(file, f"moves {moving} pixels of table and room, which stand still")
        return
    if tables is not None and here.own.depth_m is not None and not here.is_late:
        for name, identity, move in _rigid_parts(*tables):
            right = _right_share(here, matches, identity, move)
            if right is not None and right < LEAST_RIGHT:
                text = f"leads {1 - right:.1%} of the pixels of {name} elsewhere than its poses"
                yield Fault(file, f"{text} in truth.parquet")
                return
    if back is None:
        return
    closed = _closed_share(here, there, matches, back, at)
    if closed is not None and closed < LEAST_CLOSED:
        yield Fault(
            file, f"to the other frame and back, {1 - closed:.1%} of its pixels do not close"
        )


def _moved(matches: Matches, at: PixelIndex) -> Floats:
    return np.asarray(present(matches.places_px)[at].astype(np.float64) - positions(at))


def _rigid_parts(one: FrameTables, other: FrameTables) -> Iterator[tuple[str, int, Move]]:
    """Name, instance id and motion of the parts that are one rigid body: the head, objects."""
    rows = [(TARGETS[HEAD], 1 + HEAD, one.rows[HEAD], other.rows[HEAD])]
    rows += [
        (str(a["object"]), FIRST_OBJECT + o, a, b)
        for o, (a, b) in enumerate(zip(one.objects, other.objects, strict=True))
    ]
    for name, identity, before, after in rows:
        turn = rotation_of(after) * rotation_of(before).inv()
        places = [np.array([row[f"{axis}_m"] for axis in "xyz"]) for row in (before, after)]

        def move(points: Floats, turn: Rotation = turn, places: list[Floats] = places) -> Floats:
            return np.asarray(turn.apply(points - places[0]) + places[1])

        yield name, identity, move


def _right_share(view: FrameView, matches: Matches, identity: int, move: Move) -> float | None:
    """Share of the pixels of an instance that the flow leads where its motion does."""
    ys, xs = np.nonzero(present(view.own.seg) == identity)
    at = ys, xs
    depth_m = present(view.own.depth_m)[at].astype(np.float64)
    mine = np.isfinite(depth_m) & (matches.status[at] != NO_SURFACE)
    mine &= np.abs(_moved(matches, at)).max(axis=1) < REACH_PX
    if np.count_nonzero(mine) < FEW:
        return None
    own, depth_m = select(at, mine), depth_m[mine]
    expected, met_m = view.rays.project(move(view.rays.points(own, depth_m)))
    off = np.linalg.norm(present(matches.places_px)[own] - expected, axis=1)
    # Half a unit of depth moves the expected pixel by no more than the way that it goes.
    slack = np.linalg.norm(expected - positions(own), axis=1) * DEPTH_UNIT_M / met_m
    finite = np.isfinite(off)
    allowed = CLOSES_PX + 1 / FLOW_SCALE + slack
    return float(np.mean(off[finite] <= allowed[finite])) if finite.any() else None


def _closed_share(
    here: FrameView, there: FrameView, matches: Matches, back: Matches, at: PixelIndex
) -> float | None:
    """Share of the moving pixels that the other frame's flow leads home."""
    moving = np.linalg.norm(_moved(matches, at), axis=1) > 1 / FLOW_SCALE
    places, size = present(matches.places_px)[at].astype(np.float64), here.rays.size
    going = moving & (matches.status[at] == SEEN) & inside(places, size)
    own, there_px = select(at, going), places[going]
    seg = present(here.own.seg)[own]
    same = (corners(present(there.own.seg), there_px) == seg).all(axis=0)
    places_back = present(back.places_px)
    off = off_home(places_back, there_px, positions(own))
    same &= np.isfinite(off)
    if np.count_nonzero(same) < FEW:
        return None
    # Between fingers, or bone and bone, the flow bends: only where it is straight does it close.
    chosen = most(straight(places_back, there_px[same]))
    return float(np.mean(off[same][chosen] <= HOME_PX))
