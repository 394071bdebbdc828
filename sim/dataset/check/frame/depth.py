"""Depth against the ids, and against the targets' centres and surfaces that the truth has."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator

import numpy as np

from pjpdaf.camera import to_camera
from pjpdaf.targets import TARGETS
from sim.dataset.check.fault import Fault
from sim.dataset.check.frame.arrays import FrameArrays, present
from sim.dataset.check.frame.pixel_rays import RigRays
from sim.dataset.check.frame.view import FEW, is_static
from sim.dataset.check.frame_tables import FrameTables
from sim.dataset.files.layout import DEPTH_UNIT_M, TRUTH
from sim.dataset.labels.instances import NOTHING, PERSON

MOST_CHANGED = 0.005  # of static pixels
# Of a mean of depths off by half a unit each, along rays up to 1.4 times as long.
SURFACE_M = 1.5e-4
FASTEST_MPS2 = 60.0  # acceleration of a hand
THICK_M = 0.2  # between a target's centre and the middle of its visible skin, along the ray


def check_validity(frame: FrameArrays, view: int) -> Iterator[Fault]:
    """Check that depth is there where the ids show the person, and nowhere without a surface."""
    arrays, file = frame.views[view], frame.file("depth", view)
    if arrays.depth_m is None or arrays.seg is None:
        return
    there = np.isfinite(arrays.depth_m)
    void = int(np.count_nonzero(there & (arrays.seg == NOTHING)))
    lost = int(np.count_nonzero(~there & (arrays.seg != NOTHING) & (arrays.seg <= PERSON)))
    if void:
        yield Fault(file, f"has depth at {void} pixels whose id is of nothing")
    if lost:
        yield Fault(file, f"has no depth at {lost} pixels of the person")


def check_targets(
    frame: FrameArrays,
    tables: FrameTables,
    rig: RigRays,
    suspects: Callable[[], Iterable[int]],
) -> Iterator[Fault]:
    """Check the depth of the targets against truth.parquet.

    suspects: the views to name where both views' depth together put a surface elsewhere.
    """
    faults = list(_misplaced(frame, tables, rig))
    if faults or any(view.depth_m is None for view in frame.views):
        yield from faults
        return
    offset = _surface_offset(frame, tables, rig)
    if offset is None:
        return
    target, off_m = offset
    for view in suspects():
        other_file = frame.file("depth", 1 - view).partition("/")[2]
        yield Fault(
            frame.file("depth", view),
            f"with {other_file}, puts the visible surface of {target} "
            f"{1e3 * off_m:.3g} mm from where {TRUTH} has it",
        )


def changed_views(frame: FrameArrays, other: FrameArrays) -> list[int]:
    """Views whose depth of table and room differs from that of another frame."""
    changed = []
    for v, (view, reference) in enumerate(zip(frame.views, other.views, strict=True)):
        if view.depth_m is None or reference.depth_m is None:
            continue
        if view.seg is None or reference.seg is None:
            continue
        static = is_static(view.seg) & (view.seg == reference.seg)
        moved = np.abs(view.depth_m[static] - reference.depth_m[static]) > 2 * DEPTH_UNIT_M
        if len(moved) >= FEW and moved.mean() > MOST_CHANGED:
            changed.append(v)
    return changed


def _misplaced(frame: FrameArrays, tables: FrameTables, rig: RigRays) -> Iterator[Fault]:
    """Views whose depth of a target is nowhere near its centre, with the first such target."""
    for v, (view, rays) in enumerate(zip(frame.views, rig.views, strict=True)):
        if view.depth_m is None or view.seg is None:
            continue
        centres_m = to_camera(rays.camera, tables.truth.centres_m)[:, 2]
        for t, target in enumerate(TARGETS):
            depth = view.depth_m[view.seg == 1 + t]
            if not np.isfinite(depth).any():
                continue
            middle_m = float(np.nanmedian(depth))
            if abs(middle_m - centres_m[t]) > THICK_M:
                yield Fault(
                    frame.file("depth", v),
                    f"shows {target} at {middle_m:.4g} m; "
                    f"{TRUTH} has its centre at {centres_m[t]:.4g}",
                )
                break


def _surface_offset(
    frame: FrameArrays, tables: FrameTables, rig: RigRays
) -> tuple[str, float] | None:
    """The target whose visible surface is not where the truth has it, and its distance [m].

    With shutter skew the right view's points are moved back by the target's velocity; the effect
    of an acceleration is allowed.
    """
    T = len(TARGETS)
    total, count, right = np.zeros((T, 3)), np.zeros(T), np.zeros(T)
    for v, (view, rays) in enumerate(zip(frame.views, rig.views, strict=True)):
        depth_m, seg = present(view.depth_m), present(view.seg)
        for t in range(T):
            flat = np.flatnonzero(seg == 1 + t)
            depth = depth_m.ravel()[flat].astype(np.float64)
            points = np.take(rays.rays_w.reshape(-1, 3), flat, axis=0) * depth[:, None]
            total[t] += points.sum(axis=0) + len(flat) * rays.camera.centre_w
            count[t] += len(flat)
            if v == 1:
                right[t] = len(flat)
                total[t] -= len(flat) * rig.skew_s * tables.truth.velocities_mps[t]
    some = count > 0
    off = np.zeros(T)
    surfaces_m = tables.truth.surfaces_m
    off[some] = np.linalg.norm(total[some] / count[some, None] - surfaces_m[some], axis=1)
    allowed = SURFACE_M + right / np.maximum(count, 1) * FASTEST_MPS2 * rig.skew_s**2 / 2
    worst = int(np.argmax(np.nan_to_num(off, nan=np.inf) - allowed))
    if off[worst] <= allowed[worst]:
        return None
    return TARGETS[worst], float(off[worst])
