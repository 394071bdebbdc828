"""Depth of one view against the other's: from view to view and back, each pixel must close.

Depth files are whole DEPTH_UNIT_M: off by half a unit at most. Half a unit of one view moves a
point in the other view by f B / z^2 times it; there and back, both views' add up.
`RigRays.tolerance_px` is that above CLOSES_PX, and is all that is allowed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Floats
from sim.dataset.check.fault import Fault
from sim.dataset.check.frame.arrays import present
from sim.dataset.check.frame.pixel_rays import (
    PixelIndex,
    bilinear,
    corners,
    inside,
    most,
    positions,
    select,
)
from sim.dataset.check.frame.view import FEW, FrameView, is_static
from sim.scene.world import CAMERAS

STEP = 4  # every STEP-th pixel of every STEP-th row is compared
# Of 148 views of varied rooms at 160 x 120 pixels and more, 99.7 % and more closed, the median
# within 0.001 px, and 0.3 % at most lay behind the surface that hides them; of 64 at 64 x 48,
# through a lens, 98.3 %, 0.0014 px and 1.7 %.
LEAST_CLOSED, MEDIAN_PX, MOST_BEHIND = 0.97, 0.02, 0.025


@dataclass(frozen=True, eq=False)
class Correspondences:
    """Pixels of one view that the other shows too. other_px (n, 2): positions in the other view."""

    at: PixelIndex
    other_px: Floats


@dataclass(frozen=True, eq=False)
class Closing:
    """Agreement of a view's depth with the other's.

    closed: share of the pixels; median_px: over all pixels; behind: share of the pixels that the
    other view's depth would have to hide, and does not; matches: the pixels that close.
    """

    pixels: int
    closed: float
    median_px: float
    behind: float
    matches: Correspondences

    @property
    def good(self) -> bool:
        """Whether both depths are of one scene and one rig."""
        return self.pixels < FEW or (
            self.closed >= LEAST_CLOSED
            and self.median_px <= MEDIAN_PX
            and self.behind <= MOST_BEHIND
        )


def closing(view: FrameView, static_only: bool, step: int = STEP) -> Closing:
    """Project a view's pixels into the other view, from there by its depth to a point, and back.

    static_only: only table and room, which never move, for views of two moments. Only where the
    four pixels around the position are of the same instance as the pixel.
    """
    here, there = view.rays, view.other_rays
    seg, other_seg = present(view.own.seg), present(view.other.seg)
    at = here.grid(step)
    depth = present(view.own.depth_m)[at].astype(np.float64)
    known = np.isfinite(depth)
    if static_only:
        known &= is_static(seg[at])
    at, depth = select(at, known), depth[known]
    other_px, expected_m = there.project(here.points(at, depth))
    ahead = inside(other_px, there.size) & (expected_m > 0)
    at, other_px, expected_m = select(at, ahead), other_px[ahead], expected_m[ahead]
    around = corners(present(view.other.depth_m), other_px).astype(np.float64)
    same = (corners(other_seg, other_px) == seg[at]).all(axis=0) & np.isfinite(around).all(axis=0)
    at, other_px, expected_m, around = (
        select(at, same),
        other_px[same],
        expected_m[same],
        around[:, same],
    )
    met_m = 1 / bilinear(1 / around, other_px)
    back, back_m = here.project(there.backproject(other_px, met_m))
    off = np.linalg.norm(back - positions(at), axis=1)
    off = np.where(np.isfinite(off), off, np.inf)
    close = off <= view.rig.tolerance_px(expected_m)
    covered = ~close & (met_m < expected_m) & _shown(view, back, back_m)
    compared = most(view.rig.smooth(present(view.other.depth_m), other_px, expected_m) & ~covered)
    at, other_px, off, close, behind = (
        select(at, compared),
        other_px[compared],
        off[compared],
        close[compared],
        (met_m > expected_m)[compared],
    )
    n = max(len(off), 1)
    return Closing(
        pixels=len(off),
        closed=float(close.sum() / n),
        median_px=float(np.median(off)) if len(off) else 0.0,
        behind=float(np.count_nonzero(~close & behind) / n),
        matches=Correspondences(select(at, close), other_px[close]),
    )


def _shown(view: FrameView, pixels: Floats, depth_m: Floats) -> NDArray[np.bool_]:
    """Which points at these positions (n, 2) and depths (n,) the view's own depth allows.

    They are seen there, or hidden by what is nearer, or beyond the picture.
    """
    shown = ~inside(pixels, view.rays.size)
    around = corners(present(view.own.depth_m), pixels[~shown]).astype(np.float64)
    behind_px = view.rig.scale_px_m * (1 / np.fmin.reduce(around) - 1 / depth_m[~shown])
    shown[~shown] = behind_px >= -view.rig.tolerance_px(depth_m[~shown])
    return shown


def closing_fault(view: FrameView, result: Closing) -> Fault:
    """The fault of depth that does not close from this view."""
    other_file = view.other_file("depth").partition("/")[2]
    return Fault(
        view.file("depth"),
        f"to {CAMERAS[1 - view.view]} and back by {other_file}, {result.closed:.1%} of "
        f"pixels close, the median is {result.median_px:.3g} px off",
    )
