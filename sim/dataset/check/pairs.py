"""Disparity, occlusion and correspondence against depth and against each other."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Floats
from pjpdaf.calibration import rectify
from pjpdaf.camera import StereoRig
from sim.dataset.check.depth import CLOSES_PX, LEAST_CLOSED, STILL, tolerance_px
from sim.dataset.check.fault import Fault
from sim.dataset.check.frame import Frame
from sim.dataset.check.pixel_rays import PixelRays, Places, corners, inside, mixed
from sim.dataset.files.layout import DISPARITY_SCALE, FLOW_SCALE
from sim.dataset.labels.instances import PERSON
from sim.dataset.labels.records import HIDDEN, NO_SURFACE, OUT_OF_FRAME, SEEN
from sim.scene.world import CAMERAS

STEP = 6
FEW = 50
BORDER_PX = 0.01  # from the picture's border, where rounded numbers do not tell the side
JUMP_PX = 1.0  # of disparity from one pixel to the next; more is an edge
LEAST_RIGHT = 0.97  # of pixels whose status the other view's labels confirm
MOST_GONE = 0.01  # of the person's pixels, over JUMP_PX from where they should be; 0.002 were
REACH_PX = 511.0  # as far as a correspondence can be written


class RectifiedSights:
    """The rectified pair's two cameras; disparity = scale_px_m / depth + shift_px."""

    def __init__(self, rig: StereoRig) -> None:
        R1, R2, P1, P2, *_ = rectify(rig)
        self.sights = tuple(
            PixelRays(
                replace(
                    camera,
                    K=P[:, :3],
                    R_cw=R @ camera.R_cw,
                    t_cw=R @ camera.t_cw,
                    distortion=np.zeros(0),
                )
            )
            for camera, R, P in zip(rig.cameras, (R1, R2), (P1, P2), strict=True)
        )
        self.scale_px_m = -float(P2[0, 3])
        self.shift_px = float(P1[0, 2] - P2[0, 2])


def disparity_wrong(
    frame: Frame, view: int, pair: RectifiedSights, sights: tuple[PixelRays, PixelRays], still: bool
) -> float | None:
    """Share of the pixels of disparity_* whose surface is not where the view's depth has it, where
    they are too many; else None.

    Too many of all pixels, or of those of the person, which is all that a label of another frame
    has in another place.
    """
    eye = frame.eyes[view]
    assert eye.rectified is not None
    assert eye.rectified.disparity_px is not None
    assert eye.depth_m is not None
    assert eye.seg is not None
    here, real = pair.sights[view], sights[view]
    at = here.grid(STEP)
    disparity = eye.rectified.disparity_px[at].astype(np.float64) - pair.shift_px
    known = disparity > 0
    at, disparity = _chosen(at, known), disparity[known]
    places, expected_m = real.places(here.points(at, pair.scale_px_m / disparity))
    ahead = inside(places, real.size)
    places, expected_m = places[ahead], expected_m[ahead]
    ids = corners(eye.seg, places)
    around = 1 / corners(eye.depth_m, places).astype(np.float64)
    same = (ids == ids[0]).all(axis=0) & np.isfinite(around).all(axis=0)
    if still:
        same &= np.isin(ids[0], STILL)
    if np.count_nonzero(same) < FEW:
        return None
    met = mixed(around[:, same], places[same])
    off = pair.scale_px_m * np.abs(met - 1 / expected_m[same])
    allowed = tolerance_px(sights, expected_m[same]) + 1 / DISPARITY_SCALE
    wrong = float(np.mean(off > allowed))
    even = np.ptp(around[:, same], axis=0) * pair.scale_px_m < JUMP_PX
    gone = (off > allowed + JUMP_PX)[even & (ids[0][same] <= PERSON)]
    if len(gone) >= FEW and gone.mean() > MOST_GONE:
        return max(wrong, float(gone.mean()))
    return wrong if wrong > 1 - LEAST_CLOSED else None


def occlusion_faults(frame: Frame, view: int) -> list[Fault]:
    """Of occlusion_*: its values, where they say it lies, what the other view's disparity says."""
    own, other = frame.eyes[view].rectified, frame.eyes[1 - view].rectified
    assert own is not None
    assert own.disparity_px is not None
    status, disparity = own.status, own.disparity_px
    file, width = frame.file("occlusion", view), status.shape[1]
    if int(status.max()) > OUT_OF_FRAME:
        return [Fault(file, f"has the value {int(status.max())}; known are 0 to {OUT_OF_FRAME}")]
    none = status == NO_SURFACE
    odd = int(np.count_nonzero(none != np.isnan(disparity)))
    if odd:
        what = f"says at {odd} pixels otherwise than {frame.file('disparity', view)} if there is"
        return [Fault(file, f"{what} a surface")]
    ys, xs = np.mgrid[STEP // 2 : status.shape[0] : STEP, : status.shape[1]]
    status, moved = status[ys, xs], disparity[ys, xs]
    x = xs + (moved if view else -moved)
    reached = (status == SEEN) | (status == HIDDEN)
    out = reached & ((x < -0.5 - BORDER_PX) | (x > width - 0.5 + BORDER_PX))
    if out.any():
        return [Fault(file, f"says of {int(out.sum())} pixels outside the other view: inside")]
    if other is None or other.disparity_px is None:
        return []
    met = np.where(np.isnan(other.disparity_px), -np.inf, other.disparity_px)
    first = np.clip(np.floor(np.where(reached, x, 0.0)).astype(int), 0, width - 1)
    around = np.stack([met[ys, np.minimum(first + dx, width - 1)] for dx in (0, 1)])
    seen = (np.abs(around - moved) <= JUMP_PX).any(axis=0)[status == SEEN]
    hidden = (around > moved).all(axis=0)[status == HIDDEN]
    faults = []
    for what, right in (("seen", seen), ("hidden", hidden)):
        if len(right) >= FEW and right.mean() < LEAST_RIGHT:
            text = f"calls pixels {what} that {frame.file('disparity', 1 - view)} says are not"
            faults.append(Fault(file, f"{text} ({1 - right.mean():.1%} of them)"))
    return faults


def correspondence_faults(
    frame: Frame, view: int, sights: tuple[PixelRays, PixelRays], still: bool
) -> list[Fault]:
    """Of correspondence_*: against the view's depth, and to the other view and back.

    still: where this view's depth is of another moment than the correspondence.
    """
    own, other = frame.eyes[view], frame.eyes[1 - view]
    assert own.matches is not None
    assert own.matches.places_px is not None
    file, status = frame.file("correspondence", view), own.matches.status
    if int(status.max()) > OUT_OF_FRAME:
        return [Fault(file, f"has the status {int(status.max())}; known are 0 to {OUT_OF_FRAME}")]
    at = sights[view].grid(STEP)
    places = own.matches.places_px[at].astype(np.float64)
    flag, size = status[at], sights[1 - view].size
    low, high = -0.5 - 1 / FLOW_SCALE, np.array([size[1], size[0]]) - 0.5 + 1 / FLOW_SCALE
    within = ((places >= low) & (places <= high)).all(axis=1)
    reached = (flag == SEEN) | (flag == HIDDEN)
    out = int(np.count_nonzero(reached & ~within))
    if out:
        return [Fault(file, f"says of {out} pixels outside the other view: inside")]
    if own.depth_m is not None and own.seg is not None:
        depth = own.depth_m[at].astype(np.float64)
        near = np.abs(places - np.column_stack(at[::-1])).max(axis=1) < REACH_PX
        known = np.isfinite(depth) & (flag != NO_SURFACE) & near
        if still:
            known &= np.isin(own.seg[at], STILL)
        points = sights[view].points(_chosen(at, known), depth[known])
        expected, met_m = sights[1 - view].places(points)
        off = np.linalg.norm(places[known] - expected, axis=1)
        told = np.isfinite(off)
        good = off[told] <= tolerance_px(sights, met_m[told]) + 1 / FLOW_SCALE
        if len(good) >= FEW and good.mean() < LEAST_RIGHT:
            what = f"leads {1 - good.mean():.1%} of pixels elsewhere than"
            return [Fault(file, f"{what} {frame.file('depth', view)}")]
    back = other.matches.places_px if other.matches is not None else None
    if back is None:
        return []
    going = (flag == SEEN) & inside(places, size)
    start, there = np.column_stack(at[::-1])[going], places[going]
    around = np.stack([corners(back[..., i], there) for i in (0, 1)], axis=-1).astype(np.float64)
    even = np.isfinite(around).all(axis=(0, 2)) & (np.ptp(around, axis=0).max(axis=1) < 2 + JUMP_PX)
    home = np.stack([mixed(around[:, even, i], there[even]) for i in (0, 1)], axis=-1)
    off = np.linalg.norm(home - start[even], axis=1)
    share = float(np.mean(off <= CLOSES_PX + 2 / FLOW_SCALE)) if len(off) >= FEW else 1.0
    if share < LEAST_CLOSED:
        what = f"to {CAMERAS[1 - view]} and back, {1 - share:.1%} of its pixels do not close"
        return [Fault(file, what)]
    return []


def float_faults(frame: Frame, view: int) -> list[Fault]:
    """Of the float twins of disparity and correspondence, as far as both are written."""
    eye = frame.eyes[view]
    if eye.floats is None:
        return []
    file, faults = frame.file("float", view, ".npz"), []
    disparity = None if eye.rectified is None else eye.rectified.disparity_px
    places = None if eye.matches is None else eye.matches.places_px
    for key, array, unit in (
        ("disparity_px", disparity, 1 / DISPARITY_SCALE),
        ("places_px", places, 1 / FLOW_SCALE),
    ):
        if array is None:
            continue
        exact = eye.floats.get(key)
        if exact is None or exact.shape != array.shape:
            faults.append(Fault(file, f"has no {key} of the pictures' size"))
            continue
        off = np.abs(exact.astype(np.float64) - array)
        if key == "places_px":
            far = np.abs(array - _own(array)).max(axis=-1) >= REACH_PX
            off[far] = 0.0
        most = float(np.nanmax(off, initial=0.0))
        if most > 0.51 * unit + 1e-4:
            faults.append(Fault(file, f"{key} differs from its PNG by up to {most:.3g} px"))
    return faults


def _own(array: NDArray[np.float32]) -> Floats:
    ys, xs = np.mgrid[: array.shape[0], : array.shape[1]]
    return np.stack([xs, ys], axis=-1).astype(np.float64)


def _chosen(at: Places, which: NDArray[np.bool_]) -> Places:
    return at[0][which], at[1][which]
