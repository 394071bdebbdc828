"""Depth against the truth's surfaces, against the other view's depth, and against its float twin.

Depth files are whole DEPTH_UNIT_M: off by half a unit at most. One view's half unit moves a place
in the other view by f B / z^2 times it; there and back, both views' add up. `tolerance_px` is that
above CLOSES_PX, and is all that is allowed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Floats
from pjpdaf.camera import to_camera
from pjpdaf.targets import TARGETS
from sim.dataset.check.fault import Fault
from sim.dataset.check.frame import Frame
from sim.dataset.check.frame_tables import FrameTables
from sim.dataset.check.pixel_rays import PixelRays, Places, corners, inside, mixed
from sim.dataset.files.layout import DEPTH_UNIT_M, TRUTH
from sim.dataset.labels.instances import NOTHING, PERSON, ROOM, TABLE
from sim.scene.world import CAMERAS

STILL = (TABLE, ROOM)  # of the same place at both moments of a rig with shutter skew
STEP = 4  # every STEP-th pixel of every STEP-th row is looked at
CLOSES_PX = 0.05
# Between four pixels of one instance lie bends and edges too: of 12 rigs' pictures, 98 % and more
# closed, the median within 0.001 px, and 1.1 % at most lay behind what hides them.
LEAST_CLOSED, MEDIAN_PX, MOST_BEHIND = 0.95, 0.02, 0.025
MOST_CHANGED = 0.005  # of still pixels
FEW = 50  # pixels, of which no share is taken
SURFACE_M = (
    1.5e-4  # of a mean of depths off by half a unit each, along rays up to 1.4 times as long
)
FASTEST_MPS2 = 60.0  # acceleration of a hand
THICK_M = 0.2  # between a target's centre and the middle of its visible skin, along the ray


@dataclass(frozen=True, eq=False)
class Crossing:
    """Pixels of one view that the other shows too. at: their rows and columns; places_px (n, 2): in
    the other view's picture.
    """

    at: Places
    places_px: Floats


@dataclass(frozen=True, eq=False)
class Closing:
    """How well a view's depth agrees with the other's. closed: share; median_px: of all; behind:
    share of those that the other view's depth would have to hide, and does not.
    """

    pixels: int
    closed: float
    median_px: float
    behind: float
    crossing: Crossing

    @property
    def good(self) -> bool:
        """Whether the two are of one scene and one rig."""
        return self.pixels < FEW or (
            self.closed >= LEAST_CLOSED
            and self.median_px <= MEDIAN_PX
            and self.behind <= MOST_BEHIND
        )


def validity_faults(frame: Frame, view: int) -> list[Fault]:
    """Depth where nothing is, and none where something is."""
    eye = frame.eyes[view]
    faults = []
    file = frame.file("depth", view)
    if eye.depth_m is not None and eye.seg is not None:
        there = np.isfinite(eye.depth_m)
        void = int(np.count_nonzero(there & (eye.seg == NOTHING)))
        lost = int(np.count_nonzero(~there & (eye.seg != NOTHING) & (eye.seg <= PERSON)))
        if void:
            faults.append(Fault(file, f"has depth at {void} pixels whose id is of nothing"))
        if lost:
            faults.append(Fault(file, f"has no depth at {lost} pixels of the person"))
    return faults


def twin_faults(frame: Frame, view: int) -> list[Fault]:
    """Of depth_m of the NPZ file, which the PNG file rounds."""
    eye, file = frame.eyes[view], frame.file("float", view, ".npz")
    if eye.floats is None or eye.depth_m is None:
        return []
    exact = eye.floats.get("depth_m")
    if exact is None or exact.shape != eye.depth_m.shape:
        return [Fault(file, "has no depth_m of the pictures' size")]
    most = float(np.nanmax(np.abs(exact.astype(np.float64) - eye.depth_m), initial=0.0))
    if most > 0.51 * DEPTH_UNIT_M:
        other = frame.file("depth", view)
        return [Fault(file, f"depth_m differs from {other} by up to {most:.3g} m")]
    return []


def misplaced(
    frame: Frame, told: FrameTables, sights: tuple[PixelRays, PixelRays]
) -> dict[int, str]:
    """Views whose depth of a target is not around its centre at all, and what is wrong."""
    found = {}
    for view, (eye, sight) in enumerate(zip(frame.eyes, sights, strict=True)):
        if eye.depth_m is None or eye.seg is None:
            continue
        centres = to_camera(sight.camera, told.truth.centres_m)[:, 2]
        for t, target in enumerate(TARGETS):
            depth = eye.depth_m[eye.seg == 1 + t]
            middle = float(np.nanmedian(depth)) if np.isfinite(depth).any() else float(centres[t])
            if abs(middle - centres[t]) > THICK_M:
                found[view] = (
                    f"shows {target} at {middle:.4g} m; {TRUTH} has its centre at {centres[t]:.4g}"
                )
                break
    return found


def surface_offset(
    frame: Frame, told: FrameTables, sights: tuple[PixelRays, PixelRays], skew_s: float
) -> tuple[str, float] | None:
    """The target whose visible surface is not where the truth says, and by how far [m].

    With shutter skew the right view's points are moved back as the target moved, as far as its
    velocity tells; what an acceleration adds is allowed.
    """
    T = len(TARGETS)
    total, count, right = np.zeros((T, 3)), np.zeros(T), np.zeros(T)
    for view, (eye, sight) in enumerate(zip(frame.eyes, sights, strict=True)):
        assert eye.depth_m is not None
        assert eye.seg is not None
        for t in range(T):
            flat = np.flatnonzero(eye.seg == 1 + t)
            depth = eye.depth_m.ravel()[flat].astype(np.float64)
            points = np.take(sight.rays_w.reshape(-1, 3), flat, axis=0) * depth[:, None]
            total[t] += points.sum(axis=0) + len(flat) * sight.camera.centre_w
            count[t] += len(flat)
            if view == 1:
                right[t] = len(flat)
                total[t] -= len(flat) * skew_s * told.truth.velocities_mps[t]
    some = count > 0
    off = np.zeros(T)
    off[some] = np.linalg.norm(
        total[some] / count[some, None] - told.truth.surfaces_m[some], axis=1
    )
    allowed = SURFACE_M + right / np.maximum(count, 1) * FASTEST_MPS2 * skew_s**2 / 2
    worst = int(np.argmax(np.nan_to_num(off, nan=np.inf) - allowed))
    if off[worst] <= allowed[worst]:
        return None
    return TARGETS[worst], float(off[worst])


def changed(frame: Frame, other: Frame) -> list[int]:
    """Views whose depth of what stands still is not that of another frame."""
    found = []
    for view, (eye, its) in enumerate(zip(frame.eyes, other.eyes, strict=True)):
        if eye.depth_m is None or its.depth_m is None or eye.seg is None or its.seg is None:
            continue
        still = np.isin(eye.seg, STILL) & (eye.seg == its.seg)
        moved = np.abs(eye.depth_m[still] - its.depth_m[still]) > 2 * DEPTH_UNIT_M
        if len(moved) >= FEW and moved.mean() > MOST_CHANGED:
            found.append(view)
    return found


def closing(
    frame: Frame, view: int, sights: tuple[PixelRays, PixelRays], still: bool, step: int = STEP
) -> Closing:
    """From a view's depth to the other view, there by its depth to a point, and back.

    still: only what stands still, for views of two moments. Only where the four pixels around the
    place are of the same instance as the pixel.
    """
    own, other = frame.eyes[view], frame.eyes[1 - view]
    assert own.depth_m is not None
    assert own.seg is not None
    assert other.depth_m is not None
    assert other.seg is not None
    here, there = sights[view], sights[1 - view]
    at = here.grid(step)
    depth = own.depth_m[at].astype(np.float64)
    known = np.isfinite(depth)
    if still:
        known &= np.isin(own.seg[at], STILL)
    at, depth = _chosen(at, known), depth[known]
    places, expected_m = there.places(here.points(at, depth))
    ahead = inside(places, there.size) & (expected_m > 0)
    at, places, expected_m = _chosen(at, ahead), places[ahead], expected_m[ahead]
    around = corners(other.depth_m, places).astype(np.float64)
    same = (corners(other.seg, places) == own.seg[at]).all(axis=0) & np.isfinite(around).all(axis=0)
    at, places, expected_m = _chosen(at, same), places[same], expected_m[same]
    met_m = 1 / mixed(1 / around[:, same], places)
    back, _ = here.places(there.back(places, met_m))
    off = np.linalg.norm(back - np.column_stack(at[::-1]), axis=1)
    off = np.where(np.isfinite(off), off, np.inf)
    close = off <= tolerance_px(sights, expected_m)
    n = max(len(off), 1)
    return Closing(
        pixels=len(off),
        closed=float(close.sum() / n),
        median_px=float(np.median(off)) if len(off) else 0.0,
        behind=float(np.count_nonzero(~close & (met_m > expected_m)) / n),
        crossing=Crossing(_chosen(at, close), places[close]),
    )


def tolerance_px(sights: tuple[PixelRays, PixelRays], depth_m: Floats) -> Floats:
    """CLOSES_PX, and what whole depth units add at these depths."""
    left, right = (sight.camera for sight in sights)
    baseline_m = float(np.linalg.norm(left.centre_w - right.centre_w))
    return np.asarray(CLOSES_PX + left.K[0, 0] * baseline_m / depth_m**2 * DEPTH_UNIT_M)


def other_depth(frame: Frame, view: int) -> str:
    """The other view's depth file, from the sequence's folder."""
    return frame.file("depth", 1 - view).partition("/")[2]


def closing_fault(frame: Frame, view: int, found: Closing) -> Fault:
    """The line for depth that does not close from this view."""
    return Fault(
        frame.file("depth", view),
        f"to {CAMERAS[1 - view]} and back by {other_depth(frame, view)}, {found.closed:.1%} of "
        f"pixels close, the median is {found.median_px:.3g} px off",
    )


def _chosen(at: Places, which: NDArray[np.bool_]) -> Places:
    return at[0][which], at[1][which]
