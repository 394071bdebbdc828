"""Sleeve evidence: how well a clothed arm from each shoulder explains a hand at a place."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.looks import BACKGROUND, CLOTHED, SKIN, Silhouette
from pjpdaf.tracker.hypotheses.geometry import Views
from pjpdaf.tracker.hypotheses.parameters import SleeveParameters

UPPER = np.linspace(0.2, 1.0, 6)  # stations along the upper arm
FORE = np.linspace(0.1, 0.75, 7)  # stations along the forearm; beyond is the hand
ACROSS = np.array([-0.7, 0.0, 0.7])  # of half the arm's width


@dataclass(frozen=True, eq=False)
class Body:
    """Where the shoulders are: right, left (2, 3) [m], and axes (3, 3): right of the picture, down,
    away from the cameras.
    """

    shoulders_m: Floats
    axes: Floats

    @staticmethod
    def under(head_m: Floats, axes: Floats, p: SleeveParameters) -> Body:
        """Shoulders of a person whose visible head is centred at head_m (3,)."""
        down = head_m + p.down_m * axes[1] + p.back_m * axes[2]
        return Body(np.array([down - p.side_m * axes[0], down + p.side_m * axes[0]]), axes)


def arm_values(
    shapes: tuple[Silhouette | None, ...],
    views: Views,
    body: Body,
    p: SleeveParameters,
    bare: bool = False,
) -> list[Floats | None]:
    """Worth of an arm's pixel there, per view: clothed 1, torso 0, background and skin below 0.

    A sleeve hides the skin that is under it: of two hands in one blob, the one whose forearm would
    run over the other is on the wrong side. bare: the forearms are skin themselves, which is 0.
    """
    middle = body.shoulders_m.mean(axis=0)
    right, down = body.axes[0], body.axes[1]
    half = 0.5 * np.linalg.norm(body.shoulders_m[1] - body.shoulders_m[0])
    corners = np.array(
        [
            middle + a * right + b * down
            for a, b in (
                (-half - 0.02, -0.06),
                (half + 0.02, -0.06),
                (half - 0.02, 0.15),
                (half - 0.03, 0.6),
                (-half + 0.03, 0.6),
                (-half + 0.02, 0.15),
            )
        ]
    )
    pixels, _ = views.project(corners)
    worth = np.zeros(256)  # of each class; `cv2.LUT` wants all that 8 bits can be
    worth[CLOTHED], worth[BACKGROUND] = 1.0, -p.bare_background
    worth[SKIN] = 0.0 if bare else -p.covered_skin
    values: list[Floats | None] = []
    for view, shape in enumerate(shapes):
        if shape is None:
            values.append(None)
            continue
        value = cv2.LUT(shape.classes, worth)
        torso = np.zeros(shape.classes.shape, np.uint8)
        polygon = np.rint((pixels[view] + 0.5) / shape.step_px - 0.5).astype(np.int32)
        cv2.fillConvexPoly(torso, cv2.convexHull(polygon), 1)
        value[(torso > 0) & (value > 0)] = 0.0
        values.append(value)
    return values


@lru_cache(maxsize=4)
def _swivels(count: int) -> tuple[Floats, Floats]:
    angle = np.arange(count) * (2 * np.pi / count)
    return np.cos(angle), np.sin(angle)


def arms(hands_m: Floats, body: Body, p: SleeveParameters) -> tuple[Floats, Floats, Floats]:
    """Elbows (n, 2, w, 3) [m] of arms from both shoulders to hands (n, 3), the swivel's penalty
    (n, 2, w), and the stretch (n, 2) [m] by which a hand is out of reach.
    """
    to_hand = hands_m[:, None] - body.shoulders_m[None]
    distance = np.linalg.norm(to_hand, axis=2)
    a, b = p.upper_arm_m, p.forearm_m
    n = to_hand / np.maximum(distance, 1e-6)[..., None]
    d = np.clip(distance, abs(a - b) + 0.02, a + b - 0.002)
    along = (a * a - b * b + d * d) / (2 * d)
    radius = np.sqrt(np.maximum(a * a - along * along, 0.0))
    down = body.axes[1]
    u = down - (n @ down)[..., None] * n
    u /= np.maximum(np.linalg.norm(u, axis=2), 1e-6)[..., None]
    after, before = [1, 2, 0], [2, 0, 1]
    w = n[..., after] * u[..., before] - n[..., before] * u[..., after]  # `np.cross` is slow
    cosine, sine = _swivels(p.swivels)
    offset = radius[..., None, None] * (
        cosine[:, None] * u[:, :, None] + sine[:, None] * w[:, :, None]
    )
    elbows = body.shoulders_m[None, :, None] + along[..., None, None] * n[:, :, None] + offset
    from_shoulder = (elbows - body.shoulders_m[None, :, None]) / a
    outward = from_shoulder @ body.axes[0] * np.array([-1.0, 1.0])[None, :, None]
    upward = -(from_shoulder @ down)
    behind = from_shoulder @ body.axes[2]
    turned = np.maximum(-outward, 0.0) + np.maximum(upward, 0.0) + np.maximum(behind - 0.3, 0.0)
    penalty = 2.0 * p.inward_penalty * turned
    return elbows, penalty, np.maximum(distance - (a + b), 0.0)


def arm_scores(
    hands_m: Floats,
    values: list[Floats | None],
    shapes: tuple[Silhouette | None, ...],
    views: Views,
    body: Body,
    p: SleeveParameters,
    fingers: Floats | None = None,
) -> Floats:
    """Best score over the swivels of an arm from each shoulder, right then left, (n, 2).

    fingers (N, n, 2): which way the fingers point in each view, 0 where unknown; they go on along
    the forearm.
    """
    n = len(hands_m)
    if n == 0:
        return np.zeros((0, 2))
    elbows, penalty, stretch = arms(hands_m, body, p)
    elbow_px, elbow_z = views.project(elbows)  # (N, n, 2, w, 2)
    hand_px, _ = views.project(hands_m)
    shoulder_px, _ = views.project(body.shoulders_m)
    total = np.zeros(penalty.shape)
    count = 0
    for view, value in enumerate(values):
        shape = shapes[view]
        if value is None or shape is None:
            continue
        step = shape.step_px
        e = elbow_px[view]
        s = np.broadcast_to(shoulder_px[view][None, :, None], e.shape)
        h = np.broadcast_to(hand_px[view][:, None, None], e.shape)
        half = 0.5 * p.sleeve_width_m * views.focal_px[view] / elbow_z[view]  # (n, 2, w)
        total += _covered(s, e, UPPER, half, value, step) * (6 / 13)
        total += _covered(e, h, FORE, half, value, step) * (7 / 13)
        count += 1
        if fingers is not None and p.finger_weight > 0:
            way = h - e
            metre = views.focal_px[view] / elbow_z[view][..., None]
            along = (way / metre / p.forearm_m * fingers[view][:, None, None]).sum(axis=-1)
            total += p.finger_weight * along
    if count == 0:
        return np.zeros((n, 2))
    best: Floats = (total / count - penalty).max(axis=2) - 2.0 * stretch
    return best


def _covered(
    start: Floats, end: Floats, stations: Floats, half: Floats, value: Floats, step: int
) -> Floats:
    """Mean value over a band between two pixels (..., 2): (...)."""
    way = end - start
    way_x, way_y = way[..., 0], way[..., 1]
    length = np.maximum(np.hypot(way_x, way_y), 1e-6)
    across_x, across_y = -way_y / length * half, way_x / length * half
    # Stations and places across come first: numpy is slow where the last axis is short.
    t, s = (a.reshape(-1, *[1] * half.ndim) for a in (stations, ACROSS))
    x = (start[..., 0] + way_x * t)[:, None] + across_x * s
    y = (start[..., 1] + way_y * t)[:, None] + across_y * s
    height, width = value.shape
    inverse = 1.0 / step
    column = ((x + 0.5) * inverse).astype(np.int32)
    row = ((y + 0.5) * inverse).astype(np.int32)
    # What is below 0 is a large number without a sign.
    inside = (column.view(np.uint32) < width) & (row.view(np.uint32) < height)
    seen = value.reshape(-1).take((row * width + column) * inside) * inside
    return np.asarray(seen.mean(axis=(0, 1)))
