"""Correspondence against depth, and from view to view and back."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from sim.dataset.check.fault import Fault
from sim.dataset.check.frame.arrays import present
from sim.dataset.check.frame.closing import LEAST_CLOSED
from sim.dataset.check.frame.disparity import LEAST_RIGHT, STEP
from sim.dataset.check.frame.pixel_rays import (
    HOME_PX,
    inside,
    most,
    off_home,
    positions,
    select,
    straight,
)
from sim.dataset.check.frame.view import FEW, FrameView, is_static
from sim.dataset.files.layout import FLOW_SCALE
from sim.dataset.labels.records import HIDDEN, NO_SURFACE, OUT_OF_FRAME, SEEN
from sim.scene.world import CAMERAS

REACH_PX = 511.0  # as far as a correspondence can be written


def check_correspondence(view: FrameView) -> Iterator[Fault]:
    """Check correspondence_*: its status, the view's depth, and the way back; the first fault."""
    own, rays, other_rays = view.own, view.rays, view.other_rays
    matches = present(own.matches)
    other_px, status = present(matches.places_px), matches.status
    file = view.file("correspondence")
    if int(status.max()) > OUT_OF_FRAME:
        yield Fault(file, f"has the status {int(status.max())}; known are 0 to {OUT_OF_FRAME}")
        return
    at = rays.grid(STEP)
    targets, flag = other_px[at].astype(np.float64), status[at]
    height, width = other_rays.size
    low, high = -0.5 - 1 / FLOW_SCALE, np.array([width, height]) - 0.5 + 1 / FLOW_SCALE
    within = ((targets >= low) & (targets <= high)).all(axis=1)
    reached = (flag == SEEN) | (flag == HIDDEN)
    out = int(np.count_nonzero(reached & ~within))
    if out:
        yield Fault(file, f"says of {out} pixels outside the other view: inside")
        return
    if own.depth_m is not None and own.seg is not None:
        depth = own.depth_m[at].astype(np.float64)
        near = np.abs(targets - positions(at)).max(axis=1) < REACH_PX
        known = np.isfinite(depth) & (flag != NO_SURFACE) & near
        if view.is_late:
            known &= is_static(own.seg[at])
        expected, met_m = other_rays.project(rays.points(select(at, known), depth[known]))
        off = np.linalg.norm(targets[known] - expected, axis=1)
        finite = np.isfinite(off)
        good = off[finite] <= view.rig.tolerance_px(met_m[finite]) + 1 / FLOW_SCALE
        if len(good) >= FEW and good.mean() < LEAST_RIGHT:
            text = f"leads {1 - good.mean():.1%} of pixels elsewhere than"
            yield Fault(file, f"{text} {view.file('depth')}")
            return
    if view.other.matches is None:
        return
    back = present(view.other.matches.places_px)
    going = (flag == SEEN) & inside(targets, other_rays.size)
    start, there = positions(at)[going], targets[going]
    off = off_home(back, there, start)
    known = np.isfinite(off)
    off = off[known][most(straight(back, there)[known])]
    share = float(np.mean(off <= HOME_PX)) if len(off) >= FEW else 1.0
    if share < LEAST_CLOSED:
        other_camera = CAMERAS[1 - view.view]
        text = f"to {other_camera} and back, {1 - share:.1%} of its pixels do not close"
        yield Fault(file, text)
