"""Disparity and occlusion of the rectified pair against depth and against the other view's."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from sim.dataset.check.fault import Fault
from sim.dataset.check.frame.arrays import FrameArrays, present
from sim.dataset.check.frame.closing import LEAST_CLOSED
from sim.dataset.check.frame.pixel_rays import (
    JUMP_PX,
    bilinear,
    corners,
    inside,
    most,
    select,
)
from sim.dataset.check.frame.view import FEW, FrameView, is_static
from sim.dataset.files.layout import DISPARITY_SCALE
from sim.dataset.labels.instances import PERSON
from sim.dataset.labels.records import HIDDEN, NO_SURFACE, OUT_OF_FRAME, SEEN

STEP = 6
BORDER_PX = 0.01  # from the picture's border, where rounded numbers do not tell the side
LEAST_RIGHT = 0.97  # of pixels whose status the other view's labels confirm
MOST_GONE = 0.01  # of the person's pixels, over JUMP_PX from where they should be; 0.002 were


def wrong_share(view: FrameView) -> float | None:
    """Share of the pixels of disparity_* whose surface is not where the view's depth has it.

    None where the share is small enough: of all pixels, and of those of the person, the only ones
    that a label of another frame has in another place.
    """
    depth_m, seg = present(view.own.depth_m), present(view.own.seg)
    stored_px = present(present(view.own.rectified).disparity_px)
    rectified, here = view.rig.rectified, view.rig.rectified_views[view.view]
    at = here.grid(STEP)
    disparity = stored_px[at].astype(np.float64) - rectified.shift_px
    known = disparity > 0
    at, disparity = select(at, known), disparity[known]
    points = here.points(at, rectified.baseline_px_m / disparity)
    pixels, expected_m = view.rays.project(points)
    ahead = inside(pixels, view.rays.size)
    pixels, expected_m = pixels[ahead], expected_m[ahead]
    ids = corners(seg, pixels)
    around_m = corners(depth_m, pixels).astype(np.float64)
    same = (ids == ids[0]).all(axis=0) & np.isfinite(around_m).all(axis=0)
    if view.is_late:
        same &= is_static(ids[0])
    if np.count_nonzero(same) < FEW:
        return None
    around, pixels, expected_m = 1 / around_m[:, same], pixels[same], expected_m[same]
    off = rectified.baseline_px_m * np.abs(bilinear(around, pixels) - 1 / expected_m)
    allowed = view.rig.tolerance_px(expected_m) + 1 / DISPARITY_SCALE
    smooth = view.rig.smooth(depth_m, pixels, expected_m)
    wrong = float(np.mean((off > allowed)[most(smooth)]))
    even = np.ptp(around, axis=0) * rectified.baseline_px_m < JUMP_PX
    gone = (off > allowed + JUMP_PX)[even & (ids[0][same] <= PERSON)]
    if len(gone) >= FEW and gone.mean() > MOST_GONE:
        return max(wrong, float(gone.mean()))
    return wrong if wrong > 1 - LEAST_CLOSED else None


def disparity_fault(view: FrameView, share: float) -> Fault:
    """The fault of a disparity file with this `wrong_share`."""
    text = f"{share:.1%} of its pixels lie elsewhere than {view.file('depth')}"
    return Fault(view.file("disparity"), text)


def check_occlusion(frame: FrameArrays, view: int) -> Iterator[Fault]:
    """Check occlusion_*: its values, their positions, and the other view's disparity there."""
    own, other = present(frame.views[view].rectified), frame.views[1 - view].rectified
    status, disparity = own.status, present(own.disparity_px)
    file, width = frame.file("occlusion", view), status.shape[1]
    if int(status.max()) > OUT_OF_FRAME:
        yield Fault(file, f"has the value {int(status.max())}; known are 0 to {OUT_OF_FRAME}")
        return
    odd = int(np.count_nonzero((status == NO_SURFACE) != np.isnan(disparity)))
    if odd:
        text = f"says at {odd} pixels otherwise than {frame.file('disparity', view)} if there is"
        yield Fault(file, f"{text} a surface")
        return
    ys, xs = np.mgrid[STEP // 2 : status.shape[0] : STEP, : status.shape[1]]
    status, moved = status[ys, xs], disparity[ys, xs]
    x = xs + (moved if view else -moved)
    reached = (status == SEEN) | (status == HIDDEN)
    out = reached & ((x < -0.5 - BORDER_PX) | (x > width - 0.5 + BORDER_PX))
    if out.any():
        yield Fault(file, f"says of {int(out.sum())} pixels outside the other view: inside")
        return
    if other is None:
        return
    other_px = present(other.disparity_px)
    met = np.where(np.isnan(other_px), -np.inf, other_px)
    first = np.clip(np.floor(np.where(reached, x, 0.0)).astype(int), 0, width - 1)
    around = np.stack([met[ys, np.minimum(first + dx, width - 1)] for dx in (0, 1)])
    seen = (np.abs(around - moved) <= JUMP_PX).any(axis=0)[status == SEEN]
    hidden = (around > moved).all(axis=0)[status == HIDDEN]
    for name, right in (("seen", seen), ("hidden", hidden)):
        if len(right) >= FEW and right.mean() < LEAST_RIGHT:
            text = f"calls pixels {name} that {frame.file('disparity', 1 - view)} says are not"
            yield Fault(file, f"{text} ({1 - right.mean():.1%} of them)")
