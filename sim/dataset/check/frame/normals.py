"""Surface normals against the shape that the depth has.

A normal of depth is that of the plane through a pixel's neighbours two to its left, right, above
and below, where all five show one instance and their depth does not jump. A bent surface is lit by
normals between its triangles', so that both agree on average, not in each pixel.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.ndimage import binary_erosion

from pjpdaf.arrays import Floats
from sim.dataset.check.fault import Fault
from sim.dataset.check.frame.arrays import present
from sim.dataset.check.frame.pixel_rays import PixelIndex, bends, select
from sim.dataset.check.frame.view import FEW, FrameView, still_pixels
from sim.dataset.labels.instances import NOTHING, PERSON

STEP, REACH_PX = 3, 2
# In 124 views of varied rooms, 160 x 120 pixels and more, the median was 0.3 degrees at most off
# on the room and 1.5 on the person, and 99.1 % and 99.6 % were nearer than WIDE; at 64 x 48, of 114
# pixels of the room, 97 %.
MOST_MEDIAN_DEG = {"room": 2.0, "person": 6.0}
WIDE_DEG, LEAST_NEAR = 45.0, {"room": 0.93, "person": 0.90}
STEP_PX = 0.5  # in depth, of widths of a pixel there: more is an edge, whose slope no normal has
# Of the still room, but for pixels beside what moves: of 152 views, 112 through a lens, none did.
CHANGED, MOST_CHANGED = 0.1, 0.002


def check_normals(view: FrameView, before: FrameView | None) -> Iterator[Fault]:
    """Check the normals of a view, given ids and depth without fault; the first fault.

    before: the view in an earlier frame, where table and room have the same normals.
    """
    own, file = view.own, view.file("normals")
    normals, seg = present(own.normals), present(own.seg)
    there = np.isfinite(normals).all(axis=-1)
    wrong = int(np.count_nonzero(there == (seg == NOTHING)))
    if wrong:
        yield Fault(
            file, f"has or lacks a normal at {wrong} pixels where {view.file('seg')} differs"
        )
        return
    if own.depth_m is None:
        return
    at, expected = _of_depth(view)
    angle = np.degrees(np.arccos(np.clip((normals[at] * expected).sum(axis=-1), -1, 1)))
    of_person = (seg[at] != NOTHING) & (seg[at] <= PERSON)
    for part, angles in (("room", angle[~of_person]), ("person", angle[of_person])):
        if len(angles) < FEW:
            continue
        median, near = float(np.median(angles)), float(np.mean(angles <= WIDE_DEG))
        if median > MOST_MEDIAN_DEG[part] or near < LEAST_NEAR[part]:
            text = f"{median:.3g} degrees off (median), {near:.0%} within {WIDE_DEG:.0f}"
            yield Fault(file, f"is not of the surfaces of {view.file('depth')}: {part} {text}")
            return
    if before is not None and before.own.normals is not None:
        # Through a lens, a pixel beside what moves is the mean of more or fewer drawn pixels.
        still = binary_erosion(still_pixels(own, before.own), np.ones((3, 3)), border_value=1)
        off = np.abs(normals - before.own.normals).max(axis=-1) > CHANGED
        changed = int(np.count_nonzero(off & still))
        if changed > MOST_CHANGED * np.count_nonzero(still):
            text = f"has other normals at {changed} pixels of the still room than"
            yield Fault(file, f"{text} {before.file('normals')}")


def _of_depth(view: FrameView) -> tuple[PixelIndex, Floats]:
    """Pixels, and the normals (n, 3) of their depth in the camera's frame."""
    depth_m, seg, rays = present(view.own.depth_m), present(view.own.seg), view.rays
    at = rays.grid(STEP)
    height, width = depth_m.shape
    ys, xs = at
    inside = (ys >= REACH_PX) & (ys < height - REACH_PX) & (xs >= REACH_PX)
    at = select(at, inside & (xs < width - REACH_PX))
    ys, xs = at
    sides = [(ys, xs - REACH_PX), (ys, xs + REACH_PX), (ys - REACH_PX, xs), (ys + REACH_PX, xs)]
    flat = bends(1 / depth_m) * depth_m * rays.camera.K[0, 0] <= STEP_PX
    even = flat[at]
    for side in sides:
        even &= flat[side] & (seg[side] == seg[at])
    at, sides = select(at, even), [select(side, even) for side in sides]
    left, right, above, below = (
        rays.points(side, depth_m[side].astype(np.float64)) for side in sides
    )
    across_w = np.cross(below - above, right - left)
    normals = across_w @ rays.camera.R_cw.T
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return at, normals
