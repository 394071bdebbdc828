"""First positions of head and hands, thesis 3.6."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations, product
from typing import Protocol

import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.camera import Camera, project, to_camera, triangulate
from pjpdaf.checks import AboveZero, check_bounds
from pjpdaf.interfaces import Detections
from pjpdaf.tracker.thesis_units import MM2, MM2_PER_FRAME2

FOREARM_M = 0.27  # of an adult
MOST_CANDIDATES = 6  # blobs a view that may be a hand, largest first


@dataclass(frozen=True)
class StartParameters:
    """First state (section 3.6): positions by triangulation (Eq. 3.45), at rest, with P_0."""

    # P_0 = diag(p p p v v v) of Table 4.1: p = 70 mm^2 [m^2] ...
    start_position_m2: AboveZero = 70 * MM2
    # ... and v = 30 (mm/frame)^2 [(m/s)^2].
    start_velocity_m2ps2: AboveZero = 30 * MM2_PER_FRAME2
    # Start only where every target triangulates within this distance in each view [px], ... Ours.
    start_residual_px: AboveZero = 10.0
    # ... within this depth [m], ...
    start_depth_m: tuple[float, float] = (0.3, 5.0)
    # ... and the hands lie within this distance of the head [m].
    start_reach_m: AboveZero = 1.2

    def __post_init__(self) -> None:
        check_bounds("TrackerParameters", self)


class Starter(Protocol):
    """First positions from the detections of a frame."""

    def __call__(
        self,
        cameras: tuple[Camera, ...],
        detections: tuple[Detections, ...],
        parameters: StartParameters,
    ) -> Floats | None:
        """Positions (T, 3) [m], or None where this frame does not suffice."""
        ...


def start_covariance(parameters: StartParameters) -> Floats:
    """P_0 of Table 4.1, (6, 6) [m^2, m^2/s^2]."""
    position, velocity = parameters.start_position_m2, parameters.start_velocity_m2ps2
    return np.asarray(np.diag([position] * 3 + [velocity] * 3))


def find_head_and_hands(
    cameras: tuple[Camera, ...], detections: tuple[Detections, ...], parameters: StartParameters
) -> Floats | None:
    """Positions of head, right hand, left hand (3, 3) [m]; None where this frame does not suffice.

    The largest area at the top is the head; below it, the person's right hand is left in the
    picture. The views must agree: every target triangulates from the first two views (Eq. 3.45)
    within `start_residual_px` and `start_depth_m` in every view that has a blob there, and the
    hands lie within `start_reach_m` of the head. Of several pairs of hands the pair on both sides
    of the head wins, then the pair further apart than a forearm is long (a watch cuts a bare arm in
    two), then the pair with the largest area.
    """
    if len(cameras) < 2 or len(detections) != len(cameras):
        return None
    if any(view.missing or len(view) < 3 for view in detections):
        return None
    heads = [head_of(view) for view in detections]
    if any(head is None for head in heads):
        return None
    head = locate(cameras, _centres(detections, heads), parameters)
    if head is None:
        return None
    hands = [
        (blobs, point)
        for blobs in product(*map(_below, detections, heads))
        if (point := locate(cameras, _centres(detections, blobs), parameters)) is not None
        and np.linalg.norm(point - head) <= parameters.start_reach_m
    ]
    best: tuple[tuple[bool, bool, float], Floats] | None = None
    for (first, first_m), (second, second_m) in combinations(hands, 2):
        sides = [_side(view, a, b) for view, a, b in zip(detections, first, second, strict=True)]
        if abs(sum(sides)) != len(sides):
            continue  # the same blob twice, or the views disagree on left and right
        area = sum(
            float(view.areas_px[a] + view.areas_px[b])
            for view, a, b in zip(detections, first, second, strict=True)
        )
        around = all(
            _side(view, a, top) == side == _side(view, top, b)
            for view, a, b, top, side in zip(detections, first, second, heads, sides, strict=True)
            if top is not None
        )
        apart = bool(np.linalg.norm(first_m - second_m) > FOREARM_M)
        rank = around, apart, area
        if best is None or rank > best[0]:
            right, left = (first_m, second_m) if sides[0] > 0 else (second_m, first_m)
            best = rank, np.array([head, right, left])
    return None if best is None else best[1]


def _centres(detections: tuple[Detections, ...], blobs: Sequence[int | None]) -> Floats:
    """Centre of one blob a view, (N, 2) [px]."""
    return np.array([view.centres_px[i] for view, i in zip(detections, blobs, strict=True)])


def _side(view: Detections, a: int, b: int) -> int:
    """1 where blob a is left of blob b in the picture, -1 right of it, 0 neither."""
    return int(np.sign(view.centres_px[b, 0] - view.centres_px[a, 0]))


def head_of(view: Detections) -> int | None:
    """Return the largest blob with at least two others below it; None where there is none."""
    heights = view.centres_px[:, 1]
    at_top = [i for i in range(len(view)) if np.sum(heights > heights[i]) >= 2]
    return max(at_top, key=lambda i: float(view.areas_px[i]), default=None)


def _below(view: Detections, head: int | None) -> list[int]:
    """Candidates for hands: the largest blobs below the head."""
    assert head is not None
    lower = np.flatnonzero(view.centres_px[:, 1] > view.centres_px[head, 1]).tolist()
    return sorted(lower, key=lambda i: -float(view.areas_px[i]))[:MOST_CANDIDATES]


def locate(
    cameras: tuple[Camera, ...], pixels: Floats, parameters: StartParameters
) -> Floats | None:
    """Triangulate a point (3,) [m] from a pixel of each view (N, 2) (Eq. 3.45).

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
