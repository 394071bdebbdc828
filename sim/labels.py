"""The truth of a frame, from its pose and its rendered ids and depth."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import cv2
import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Floats
from pjpdaf.camera import Camera, undistort_points
from pjpdaf.targets import TARGETS
from sim.camera.render import ViewRender
from sim.event_names import merge_name
from sim.pose import Pose
from sim.scene.world import CAMERAS
from sim.script import Script
from sim.truth import Truth, ViewTruth

VELOCITY_STEP_S = 0.005  # half the interval of the central difference
TOUCH_PX = 2  # visible skin no farther apart than this is one blob to a detector


def centres(pose: Pose) -> Floats:
    """Centres of head, right palm, left palm (3, 3) [m], world."""
    return np.stack([part.position_m for part in (pose.head, *pose.hands)])


def velocities(script: Script, t_s: float) -> Floats:
    """Velocities of the centres (3, 3) [m/s]: central difference, one-sided at the start."""
    before, after = max(t_s - VELOCITY_STEP_S, 0.0), t_s + VELOCITY_STEP_S
    moved = centres(script.pose(after)) - centres(script.pose(before))
    return np.asarray(moved / (after - before))


def truth_of(
    index: int,
    pose: Pose,
    velocities_mps: Floats,
    views: Sequence[ViewRender],
    cameras: Sequence[Camera],
    events: tuple[str, ...] = (),
    moved_m: Sequence[Floats] | None = None,
) -> Truth:
    """The truth of a frame, from both views rendered with labels and amodal counts.

    events: of the script; merges are added, such as `merge:right_hand+left_hand:left_view`.
    moved_m: per view, how far the targets' centres (T, 3) had moved from `pose` when that view was
    rendered, where it was rendered at another moment.
    """
    seen = tuple(view_truth(view) for view in views)
    return Truth(
        index=index,
        time_s=pose.time_s,
        centres_m=centres(pose),
        velocities_mps=velocities_mps,
        surfaces_m=visible_surfaces(views, cameras, moved_m),
        views=seen,
        events=(*events, *merge_events(seen)),
    )


def view_truth(view: ViewRender) -> ViewTruth:
    """The targets' visible skin in a view that was rendered with labels and amodal masks."""
    assert view.targets is not None, "a truth needs the labels"
    assert view.amodal_px is not None, "a truth needs the amodal counts"
    T = len(TARGETS)
    centroids, boxes = np.full((T, 2), np.nan), np.full((T, 4), np.nan)
    visible = np.zeros(T, np.int64)
    skin = skin_pixels(view.targets)
    for target, (ys, xs) in enumerate(skin):
        visible[target] = len(xs)
        if len(xs):
            centroids[target] = xs.mean(), ys.mean()
            x, y = xs.min(), ys.min()
            boxes[target] = x, y, xs.max() - x + 1, ys.max() - y + 1
    return ViewTruth(
        centroids_px=centroids,
        visible_px=visible,
        # At the picture's resolution a sliver may show in one render pass and not in the other.
        amodal_px=np.maximum(view.amodal_px, visible),
        boxes_px=boxes,
        merged=merged(view.targets, boxes),
    )


def skin_pixels(
    targets: NDArray[np.int8],
) -> tuple[tuple[NDArray[np.intp], NDArray[np.intp]], ...]:
    """Rows and columns of each target's visible skin."""
    flat = np.flatnonzero(targets >= 0)
    owner = targets.ravel()[flat]
    width = targets.shape[1]
    mine = (flat[owner == target] for target in range(len(TARGETS)))
    return tuple((own // width, own % width) for own in mine)


def merged(targets: NDArray[np.int8], boxes_px: Floats) -> NDArray[np.bool_]:
    """Which targets share a blob (T, T): masks within TOUCH_PX, directly or in a chain.

    targets (h, w): target of each pixel, -1 none; boxes_px (T, 4) of the masks, NaN where none.
    """
    T = len(boxes_px)
    joined = np.eye(T, dtype=bool)
    present = [t for t in range(T) if np.isfinite(boxes_px[t, 0])]
    for a, b in combinations(present, 2):
        joined[a, b] = joined[b, a] = _touch(targets, a, b, boxes_px)
    for _ in range(T):  # the shortest chain has at most T links
        joined = (joined.astype(int) @ joined.astype(int)) > 0
    return np.asarray(joined & ~np.eye(T, dtype=bool))


def _touch(targets: NDArray[np.int8], a: int, b: int, boxes_px: Floats) -> bool:
    pad = TOUCH_PX + 1  # a gap of TOUCH_PX empty pixels lies between pixels this far apart
    (ax, ay, aw, ah), (bx, by, bw, bh) = boxes_px[a], boxes_px[b]
    left, top = int(max(ax, bx)) - pad, int(max(ay, by)) - pad
    right, bottom = int(min(ax + aw, bx + bw)) + pad, int(min(ay + ah, by + bh)) + pad
    if left >= right or top >= bottom:
        return False
    window = targets[max(top, 0) : bottom, max(left, 0) : right]
    kernel = np.ones((2 * pad + 1, 2 * pad + 1), np.uint8)
    near = cv2.dilate((window == a).astype(np.uint8), kernel) > 0
    return bool(np.any(near & (window == b)))


def merge_events(views: Sequence[ViewTruth]) -> tuple[str, ...]:
    """A label per view and pair of targets whose visible skin is one blob."""
    events = []
    for camera, view in zip(CAMERAS, views, strict=True):
        for a, b in combinations(range(len(TARGETS)), 2):
            if view.merged[a, b]:
                events.append(merge_name(TARGETS[a], TARGETS[b], camera))
    return tuple(events)


def visible_surfaces(
    views: Sequence[ViewRender],
    cameras: Sequence[Camera],
    moved_m: Sequence[Floats] | None = None,
) -> Floats:
    """Mean of the visible skin's surface points over all views (3, 3) [m], NaN where unseen.

    moved_m: as in `truth_of`; each view's points are moved back with their target.
    """
    T = len(TARGETS)
    total, count = np.zeros((T, 3)), np.zeros(T)
    still = [np.zeros((T, 3))] * len(views)
    for view, camera, moved in zip(views, cameras, moved_m or still, strict=True):
        assert view.targets is not None
        assert view.depth_m is not None
        for target, (ys, xs) in enumerate(skin_pixels(view.targets)):
            if len(xs):
                points = back_project(camera, xs, ys, view.depth_m[ys, xs])
                total[target] += points.sum(axis=0) - len(xs) * moved[target]
                count[target] += len(xs)
    return np.asarray(total / np.where(count > 0, count, np.nan)[:, None])


def back_project(
    camera: Camera, xs: NDArray[np.intp], ys: NDArray[np.intp], depth_m: NDArray[np.float32]
) -> Floats:
    """World points (n, 3) of pixels (n,), (n,) of the real picture with planar depth (n,) [m]."""
    ideal = undistort_points(camera, np.column_stack([xs, ys]))
    rays = np.column_stack([ideal, np.ones(len(xs))]) @ np.linalg.inv(camera.K).T
    inside = rays * depth_m.astype(np.float64)[:, None]
    return np.asarray((inside - camera.t_cw) @ camera.R_cw)
