"""The truth of a painted frame: exact in three dimensions, of the painted silhouettes in a view."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import cv2
import numpy as np
from numpy.typing import NDArray

from pjpdaf.camera import Camera, distort_points
from sim.labels import merge_events
from sim.silhouettes.film import Film
from sim.silhouettes.outlines import Outlines, paint_alone
from sim.silhouettes.painter import PaintedView
from sim.silhouettes.patches import T, apart
from sim.silhouettes.shapes import TARGET_PAINT
from sim.truth import Truth, ViewTruth

_SURFACE_M = (0.075, 0.013, 0.013)  # of the visible surface before the centre: head, hands
_TOUCH_PX = 2.0  # skin no farther apart is one blob
_KERNELS = {touch: np.ones((2 * touch + 1, 2 * touch + 1), np.uint8) for touch in (1, 2, 3)}
_NOWHERE, _NO_BOX = (np.nan, np.nan), (np.nan,) * 4


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
        self._distorted = [bool(np.any(camera.distortion)) for camera in film.rig.cameras]

    def of(self, frame: int, views: Sequence[PaintedView]) -> Truth:
        """The truth of a frame that was painted as these views."""
        film = self._film
        seen = tuple(
            _view_truth(view, outlines, camera, frame, distorted)
            for view, outlines, camera, distorted in zip(
                views, film.outlines, film.rig.cameras, self._distorted, strict=True
            )
        )
        surfaces = self._surfaces[frame]
        for target, patches in enumerate(zip(*(view.patches for view in views), strict=True)):
            if not any(patches):
                surfaces = surfaces.copy()
                surfaces[target] = np.nan
        events = film.performance.script.events(film.moments[frame].time_s)
        return Truth(
            index=frame,
            time_s=film.moments[frame].time_s,
            centres_m=self._centres[frame],
            velocities_mps=self._velocities[frame],
            surfaces_m=surfaces,
            views=seen,
            events=(*events, *merge_events(seen)),
        )


def _view_truth(
    view: PaintedView, outlines: Outlines, camera: Camera, frame: int, distorted: bool
) -> ViewTruth:
    step, area = view.step_px, view.step_px**2
    centroids, boxes = [_NOWHERE] * T, [_NO_BOX] * T
    visible, amodal = [0] * T, [0] * T
    for target, patch in enumerate(view.patches):
        if patch is not None:
            left, top, right, bottom = patch.box
            visible[target] = patch.pixels * area
            centroids[target] = (
                patch.x * step + (step - 1) / 2,
                patch.y * step + (step - 1) / 2,
            )
            boxes[target] = (left * step, top * step, (right - left) * step, (bottom - top) * step)
        amodal[target] = visible[target]
        if patch is None or outlines.covered[frame][target]:
            amodal[target] = max(_amodal(outlines, frame, target) * area, visible[target])
    centres = np.array(centroids)
    if distorted and any(visible):
        seen = np.array(visible) > 0
        centres[seen] = distort_points(camera, centres[seen])
    return ViewTruth(
        centroids_px=centres,
        visible_px=np.array(visible),
        amodal_px=np.array(amodal),
        boxes_px=np.array(boxes),
        merged=_merged(view, max(1, round(_TOUCH_PX / step))),
    )


def _amodal(outlines: Outlines, frame: int, target: int) -> int:
    canvas = np.zeros(outlines.size, np.uint8)
    paint_alone(outlines, frame, TARGET_PAINT + target, canvas)
    return cv2.countNonZero(canvas)


def _merged(view: PaintedView, touch: int) -> NDArray[np.bool_]:
    """Targets whose pixels are at most `touch` pixels apart (T, T), directly or in a chain."""
    joined = np.zeros((T, T), dtype=bool)
    pairs = 0
    for a, b in combinations(range(T), 2):
        one, other = view.patches[a], view.patches[b]
        if one is None or other is None or apart(one.box, other.box, touch):
            continue
        left, top = (max(one.box[i], other.box[i]) - touch - 1 for i in (0, 1))
        right, bottom = (min(one.box[i], other.box[i]) + touch + 1 for i in (2, 3))
        window = view.classes[max(top, 0) : bottom, max(left, 0) : right]
        near = cv2.dilate((window == TARGET_PAINT + a).view(np.uint8), _KERNELS[touch])
        if cv2.countNonZero(near & (window == TARGET_PAINT + b)):
            joined[a, b] = joined[b, a] = True
            pairs += 1
    if pairs == 2:  # a chain
        joined[:] = ~np.eye(T, dtype=bool)
    return joined
