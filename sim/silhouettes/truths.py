"""The truth of a painted frame: exact in three dimensions, of the painted silhouettes in a view."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Floats
from pjpdaf.camera import Camera, distort_points
from pjpdaf.targets import TARGETS
from sim.labels import merge_events
from sim.silhouettes.film import Film
from sim.silhouettes.outlines import Outlines, overlapped, paint_alone
from sim.silhouettes.painter import PaintedView
from sim.silhouettes.shapes import TARGET_PAINT
from sim.truth import Truth, ViewTruth

_SURFACE_M = (0.075, 0.013, 0.013)  # of the visible surface before the centre: head, hands
_TOUCH_PX = 2.0  # skin no farther apart is one blob
T = len(TARGETS)


class Truths:
    """Truths of a film's frames.

    Centres and times are exact. Approximate: velocities are differences from frame to frame;
    surfaces lie before the centres by a fixed amount; visible and amodal pixels, centroids, boxes
    and merges are those of the painted pictures.
    """

    def __init__(self, film: Film) -> None:
        self._film = film
        self._centres = film.track.centres_m
        times = film.track.times_s
        self._velocities = (
            np.gradient(self._centres, times, axis=0)
            if len(times) > 1
            else np.zeros_like(self._centres)
        )
        middle = np.mean([camera.centre_w for camera in film.rig.cameras], axis=0)
        towards = middle - self._centres
        towards /= np.linalg.norm(towards, axis=-1, keepdims=True)
        self._surfaces = self._centres + np.array(_SURFACE_M)[:, None] * towards
        self._may_be_covered = [
            np.stack([overlapped(o, TARGET_PAINT + t) for t in range(T)], axis=1)
            for o in film.outlines
        ]

    def of(self, frame: int, views: Sequence[PaintedView]) -> Truth:
        """The truth of a frame that was painted as these views."""
        film = self._film
        seen = tuple(
            _view_truth(view, outlines, camera, frame, covered[frame])
            for view, outlines, camera, covered in zip(
                views, film.outlines, film.rig.cameras, self._may_be_covered, strict=True
            )
        )
        unseen = sum(view.visible_px for view in seen) == 0
        events = film.performance.script.events(film.moments[frame].time_s)
        return Truth(
            index=frame,
            time_s=film.moments[frame].time_s,
            centres_m=self._centres[frame],
            velocities_mps=self._velocities[frame],
            surfaces_m=np.where(np.asarray(unseen)[:, None], np.nan, self._surfaces[frame]),
            views=seen,
            events=(*events, *merge_events(seen)),
        )


def _view_truth(
    view: PaintedView,
    outlines: Outlines,
    camera: Camera,
    frame: int,
    covered: NDArray[np.bool_],
) -> ViewTruth:
    classes, step = view
    width = classes.shape[1]
    flat = np.flatnonzero(classes >= TARGET_PAINT)
    owner = classes.ravel()[flat] - TARGET_PAINT
    x, y = flat % width, flat // width
    centroids, boxes = np.full((T, 2), np.nan), np.full((T, 4), np.nan)
    visible = np.bincount(owner, minlength=T)
    for target in range(T):
        if visible[target]:
            own = owner == target
            xs, ys = x[own], y[own]
            low, high = (xs.min(), ys.min()), (xs.max(), ys.max())
            centroids[target] = xs.mean(), ys.mean()
            boxes[target] = *low, high[0] - low[0] + 1, high[1] - low[1] + 1
    amodal = visible.copy()
    for target in np.flatnonzero(covered | (visible == 0)).tolist():
        amodal[target] = max(_amodal(outlines, frame, target), visible[target])
    real = centroids * step + (step - 1) / 2
    if np.any(camera.distortion) and visible.any():
        real[visible > 0] = distort_points(camera, real[visible > 0])
    return ViewTruth(
        centroids_px=real,
        visible_px=visible * step * step,
        amodal_px=amodal * step * step,
        boxes_px=boxes * step,
        merged=_merged(classes, boxes, max(1, round(_TOUCH_PX / step))),
    )


def _amodal(outlines: Outlines, frame: int, target: int) -> int:
    canvas = np.zeros(outlines.size, np.uint8)
    paint_alone(outlines, frame, TARGET_PAINT + target, canvas)
    return int(np.count_nonzero(canvas))


def _merged(classes: NDArray[np.uint8], boxes: Floats, touch: int) -> NDArray[np.bool_]:
    """Targets whose pixels are at most `touch` pixels apart (T, T), directly or in a chain."""
    joined = np.eye(T, dtype=bool)
    for a in range(T):
        for b in range(a + 1, T):
            if not _boxes_touch(boxes[a], boxes[b], touch):
                continue
            ys, xs = np.nonzero(classes == TARGET_PAINT + a)
            near = np.zeros(classes.shape, dtype=bool)
            h, w = classes.shape
            for dy in range(-touch, touch + 1):
                for dx in range(-touch, touch + 1):
                    near[np.clip(ys + dy, 0, h - 1), np.clip(xs + dx, 0, w - 1)] = True
            joined[a, b] = joined[b, a] = bool((near & (classes == TARGET_PAINT + b)).any())
    if joined.sum() > T:
        for _ in range(T):
            joined = (joined.astype(int) @ joined.astype(int)) > 0
    return np.asarray(joined & ~np.eye(T, dtype=bool))


def _boxes_touch(a: Floats, b: Floats, pad: int) -> bool:
    ax, ay, aw, ah = a.tolist()
    bx, by, bw, bh = b.tolist()
    return bool(
        ax <= bx + bw + pad and bx <= ax + aw + pad and ay <= by + bh + pad and by <= ay + ah + pad
    )
