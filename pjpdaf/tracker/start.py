"""First positions of head and hands, thesis 3.6."""

from __future__ import annotations

from collections.abc import Callable
from itertools import combinations, product

import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.camera import Camera, project, to_camera, triangulate
from pjpdaf.interfaces import Detections
from pjpdaf.presets.parameters import TrackerParameters

Starter = Callable[[tuple[Camera, ...], tuple[Detections, ...], TrackerParameters], Floats | None]
MOST_CANDIDATES = 6  # blobs a view that may be a hand, largest first


def find_head_and_hands(
    cameras: tuple[Camera, ...], seen: tuple[Detections, ...], parameters: TrackerParameters
) -> Floats | None:
    """Positions of head, right hand, left hand (3, 3) [m]; None where this frame does not do.

    The largest area at the top is the head; below it, the person's right hand is left in the
    picture. The views must agree: every target triangulates from the first two views (Eq. 3.45)
    within `start_residual_px` and `start_depth_m` in every view that has a blob there, and the
    hands lie within `start_reach_m` of the head. Of several pairs of hands the one with the
    largest area wins.
    """
    if len(cameras) < 2 or len(seen) != len(cameras):
        return None
    if any(view.missing or len(view) < 3 for view in seen):
        return None
    heads = [head_of(view) for view in seen]
    if any(head is None for head in heads):
        return None
    head = locate(
        cameras,
        np.array([view.centres_px[i] for view, i in zip(seen, heads, strict=True)]),
        parameters,
    )
    if head is None:
        return None
    matches = [
        (chosen, point)
        for chosen in product(*map(_below, seen, heads))
        if (
            point := locate(
                cameras,
                np.array([view.centres_px[i] for view, i in zip(seen, chosen, strict=True)]),
                parameters,
            )
        )
        is not None
        and np.linalg.norm(point - head) <= parameters.start_reach_m
    ]
    best: tuple[float, Floats] | None = None
    for (one, point), (other, another) in combinations(matches, 2):
        sides = [_side(view, a, b) for view, a, b in zip(seen, one, other, strict=True)]
        if abs(sum(sides)) != len(sides):
            continue  # one blob twice, or the views disagree on left and right
        area = sum(
            float(view.areas_px[a] + view.areas_px[b])
            for view, a, b in zip(seen, one, other, strict=True)
        )
        if best is None or area > best[0]:
            right, left = (point, another) if sides[0] > 0 else (another, point)
            best = area, np.array([head, right, left])
    return None if best is None else best[1]


def _side(view: Detections, a: int, b: int) -> int:
    """1 where blob a is left of blob b in the picture, -1 right of it, 0 neither."""
    return int(np.sign(view.centres_px[b, 0] - view.centres_px[a, 0]))


def head_of(view: Detections) -> int | None:
    """The largest blob that has at least two others below it; None where there is none."""
    heights = view.centres_px[:, 1]
    at_top = [i for i in range(len(view)) if np.sum(heights > heights[i]) >= 2]
    return max(at_top, key=lambda i: float(view.areas_px[i]), default=None)


def _below(view: Detections, head: int | None) -> list[int]:
    """Candidates for hands: the largest blobs below the head."""
    assert head is not None
    lower = np.flatnonzero(view.centres_px[:, 1] > view.centres_px[head, 1]).tolist()
    return sorted(lower, key=lambda i: -float(view.areas_px[i]))[:MOST_CANDIDATES]


def locate(
    cameras: tuple[Camera, ...], pixels: Floats, parameters: TrackerParameters
) -> Floats | None:
    """One point from one pixel a view (N, 2) to the world, (3,) [m] (Eq. 3.45).

    None where the views do not agree: residual, depth (`start_residual_px`, `start_depth_m`).
    """
    point = triangulate(cameras, pixels)
    if not np.all(np.isfinite(point)):
        return None
    nearest, farthest = parameters.start_depth_m
    for camera, pixel in zip(cameras, pixels, strict=True):
        if not nearest <= to_camera(camera, point)[2] <= farthest:
            return None
        if np.linalg.norm(project(camera, point) - pixel) > parameters.start_residual_px:
            return None
    return point
