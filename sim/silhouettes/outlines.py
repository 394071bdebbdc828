"""Outlines of shapes in a camera's picture, over the frames of a sequence, in order of depth."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Floats
from pjpdaf.camera import Camera
from sim.silhouettes.patches import Box, T
from sim.silhouettes.shapes import BARE, TARGET_PAINT, Bars, Hull
from sim.vectors import dots

SHIFT = 4  # binary digits of a pixel's fraction, as `cv2.fillConvexPoly` takes them
# It fills every pixel that an outline touches: half a pixel more on all sides.
_BORDER_PX = 0.5
_THINNEST_PX = 0.05
_NEAREST_M = 0.05  # nearer than this a shape is not painted
_END = np.linspace(0.5 * np.pi, 1.5 * np.pi, 6)
_BULGE = np.array([1.0, *[1.0427] * 4, 1.0])  # corners lie outside the circle: its area is kept
_COS, _SIN = ((_BULGE * f(_END))[:, None, None] for f in (np.cos, np.sin))
_BETWEEN_M = 1e-4  # of depth, between a flat body and bars before and behind it
_FAR = 1 << 20  # a pixel that no picture has


@dataclass(frozen=True, eq=False)
class Outlines:
    """Outlines of n bars and h hulls over F frames, in a picture reduced by step_px.

    bars (F, n, 12, 2), hulls (h) of (F, k, 2): int32 pixels times 2^SHIFT, of which the hulls' are
    points whose convex hull is the outline; paints (n + h,); size: height, width of the picture.
    order: (F) of the shapes to paint, farthest first. target_boxes: (F) of the boxes of the
    targets, in whole pixels inside the picture; covered: (F) of whether something may lie over
    them; other_skin: whether there is skin that is no target's.
    """

    bars: NDArray[np.int32]
    hulls: tuple[NDArray[np.int32], ...]
    paints: list[int]
    order: tuple[list[int], ...]
    size: tuple[int, int]
    step_px: int
    target_boxes: list[tuple[Box, ...]]
    covered: list[list[bool]]
    other_skin: bool
    skin_boxes: list[Box]


def reduced_camera(camera: Camera, step_px: int) -> Camera:
    """The camera of the picture reduced by a whole number, without its lens distortion."""
    K = np.array(camera.K)
    K[:2] /= step_px
    K[:2, 2] += 0.5 / step_px - 0.5
    return Camera(
        K, camera.R_cw, camera.t_cw, camera.width_px // step_px, camera.height_px // step_px
    )


def outlines_of(
    bars: Bars,
    hulls: list[Hull],
    camera: Camera,
    step_px: int,
    everything: bool = True,
    hidden: NDArray[np.bool_] | None = None,
) -> Outlines:
    """Project shapes into a picture of the camera that is reduced by step_px.

    everything: paint all shapes; else only targets, other skin and what may cover them.
    hidden (F, n): bars that are not to be seen.
    """
    small = reduced_camera(camera, step_px)
    bar_pixels, bar_depths, bar_boxes = _project_bars(bars, small)
    pixels, hull_depths, hull_boxes = _project_hulls(hulls, small, len(bar_depths))
    depths_m = np.concatenate([bar_depths, hull_depths], axis=1)
    all_boxes = np.concatenate([bar_boxes, hull_boxes], axis=2)
    for index, hull in enumerate(hulls, start=len(bars.paints)):
        if hull.normals is not None:
            _order_by_plane(depths_m, all_boxes, bars, hull, index, camera)
    paints = np.concatenate([bars.paints, np.array([h.paint for h in hulls], np.uint8)])
    size = (small.height_px, small.width_px)
    wanted = _inside(all_boxes, size) & (depths_m > _NEAREST_M)
    if hidden is not None:
        wanted[:, : hidden.shape[1]] &= ~hidden
    spans = _spans(paints, depths_m, all_boxes)
    if not everything:
        wanted &= _matters(paints, spans)
    order = tuple(
        by_depth[chosen[by_depth]].tolist()
        for by_depth, chosen in zip(
            np.argsort(-depths_m, axis=1, kind="stable"), wanted, strict=True
        )
    )
    target_boxes, covered = _targets(spans, len(depths_m), size)
    return Outlines(
        bar_pixels,
        pixels,
        paints.tolist(),
        order,
        size,
        step_px,
        target_boxes,
        covered,
        bool((paints == BARE).any()),
        _skin_boxes(paints, all_boxes, size),
    )


def paint(outlines: Outlines, frame: int, canvas: NDArray[np.uint8]) -> None:
    """Paint the frame's shapes over the canvas (h, w), the nearest last."""
    bars, paints = outlines.bars[frame], outlines.paints
    count, fill = len(bars), cv2.fillConvexPoly
    for index in outlines.order[frame]:
        if index < count:
            fill(canvas, bars[index], paints[index], cv2.LINE_8, SHIFT)
        else:
            points = cv2.convexHull(outlines.hulls[index - count][frame])
            fill(canvas, points, paints[index], cv2.LINE_8, SHIFT)


def paint_alone(outlines: Outlines, frame: int, shade: int, canvas: NDArray[np.uint8]) -> None:
    """Paint only the frame's shapes of a class."""
    bars, paints = outlines.bars[frame], outlines.paints
    for index in outlines.order[frame]:
        if paints[index] == shade:
            if index < len(bars):
                cv2.fillConvexPoly(canvas, bars[index], shade, cv2.LINE_8, SHIFT)
            else:
                points = cv2.convexHull(outlines.hulls[index - len(bars)][frame])
                cv2.fillConvexPoly(canvas, points, shade, cv2.LINE_8, SHIFT)


# Coordinates are columns of their own below: numpy is several times as slow along axes of 2 or 3.
# Boxes are (4, ...): left, top, right, bottom [reduced px].


def _project_bars(bars: Bars, camera: Camera) -> tuple[NDArray[np.int32], Floats, Floats]:
    """Outlines (F, n, 12, 2), depths (F, n) and boxes (4, F, n) of bars."""
    n, corners = bars.starts_m.shape[1], len(_END)
    x, y, depth = _project(np.concatenate([bars.starts_m, bars.ends_m], axis=1), camera)
    radii = np.concatenate([bars.start_radii_m, bars.end_radii_m])
    radius = camera.K[0, 0] * radii / np.maximum(depth, _NEAREST_M)
    box = np.empty((4, *depth[:, :n].shape))
    for axis, at in enumerate((x, y)):
        low, high = at - radius, at + radius
        np.minimum(low[:, :n], low[:, n:], out=box[axis])
        np.maximum(high[:, :n], high[:, n:], out=box[axis + 2])
    drawn = np.maximum(radius - _BORDER_PX, _THINNEST_PX)
    along_x, along_y = x[:, n:] - x[:, :n], y[:, n:] - y[:, :n]
    length = np.sqrt(along_x * along_x + along_y * along_y)
    long, divisor = length > 1e-6, np.maximum(length, 1e-6)
    u, v = np.where(long, along_x / divisor, 1.0), np.where(long, along_y / divisor, 0.0)
    # The half circle behind the start, from one side to the other, and its opposite at the end.
    outline = np.empty((*u.shape, 2 * corners, 2), np.int32)
    for axis, (at, arc) in enumerate(((x, u * _COS - v * _SIN), (y, v * _COS + u * _SIN))):
        first = at[:, :n] + drawn[:, :n] * arc
        last = at[:, n:] - drawn[:, n:] * arc
        outline[:, :, :corners, axis] = np.moveaxis(_fixed(first), 0, -1)
        outline[:, :, corners:, axis] = np.moveaxis(_fixed(last), 0, -1)
    return outline, 0.5 * (depth[:, :n] + depth[:, n:]), box


def _project_hulls(
    hulls: list[Hull], camera: Camera, frames: int
) -> tuple[tuple[NDArray[np.int32], ...], Floats, Floats]:
    """Points of each hull (F, k, 2), drawn in by the border, depths (F, h) and boxes (4, F, h)."""
    if not hulls:
        return (), np.zeros((frames, 0)), np.zeros((4, frames, 0))
    sizes = np.array([hull.points_m.shape[1] for hull in hulls])
    x, y, depth = _project(np.concatenate([h.points_m for h in hulls], axis=1), camera)
    first = np.concatenate([[0], np.cumsum(sizes)[:-1]])
    box = np.empty((4, frames, len(hulls)))
    drawn = np.empty((*x.shape, 2), np.int32)
    for axis, at in enumerate((x, y)):
        low = np.minimum.reduceat(at, first, axis=1, out=box[axis])
        high = np.maximum.reduceat(at, first, axis=1, out=box[axis + 2])
        share = np.maximum(1.0 - 2 * _BORDER_PX / np.maximum(high - low, 1e-6), 0.02)
        middle = np.repeat(0.5 * (low + high), sizes, axis=1)
        drawn[..., axis] = _fixed(middle + np.repeat(share, sizes, axis=1) * (at - middle))
    mean = np.add.reduceat(depth, first, axis=1) / sizes - [hull.nearer_m for hull in hulls]
    pieces = np.split(drawn, first[1:].tolist(), axis=1)
    return tuple(pieces), mean, box


def _project(points_m: Floats, camera: Camera) -> tuple[Floats, Floats, Floats]:
    """x and y [px] (F, n), far outside where the camera cannot see them, and depths (F, n)."""
    at = points_m.reshape(-1, 3) @ camera.R_cw.T
    x, y, depth = (at[:, k] + camera.t_cw[k] for k in range(3))
    before = np.maximum(depth, 1e-9)
    behind = depth <= _NEAREST_M
    hidden = behind.any()
    for axis, pixels in enumerate((x, y)):
        pixels *= camera.K[axis, axis] / before
        pixels += camera.K[axis, 2]
        if hidden:
            pixels[behind] = _FAR
    shape = points_m.shape[:2]
    return x.reshape(shape), y.reshape(shape), depth.reshape(shape)


def _order_by_plane(
    depths_m: Floats, boxes: Floats, bars: Bars, hull: Hull, index: int, camera: Camera
) -> None:
    """Put the depths of bars (F, n + h) that overlap a flat hull on the right side of it."""
    assert hull.normals is not None
    n = len(bars.paints)
    middle = hull.points_m.mean(axis=1)
    normals = hull.normals[:, None]
    bar_side = dots(0.5 * (bars.starts_m + bars.ends_m) - middle[:, None], normals)
    camera_side = dots(camera.centre_w - middle, hull.normals)[:, None]
    own, others = boxes[:, :, index, None], boxes[:, :, :n]
    meets = ((others[:2] < own[2:]) & (others[2:] > own[:2])).all(axis=0)
    before = bar_side * camera_side > 0.0
    depth = depths_m[:, index, None]
    placed = np.where(
        before,
        np.minimum(depths_m[:, :n], depth - _BETWEEN_M),
        np.maximum(depths_m[:, :n], depth + _BETWEEN_M),
    )
    depths_m[:, :n] = np.where(meets, placed, depths_m[:, :n])


def _fixed(pixels: Floats) -> Floats:
    """Pixels times 2^SHIFT, whole numbers, in the place of the pixels."""
    pixels *= 1 << SHIFT
    return np.rint(pixels, out=pixels)


def _inside(boxes: Floats, size: tuple[int, int]) -> NDArray[np.bool_]:
    height, width = size
    left, top, right, bottom = boxes
    return np.asarray((right > -1) & (bottom > -1) & (left < width) & (top < height))


@dataclass(frozen=True, eq=False)
class _Span:
    """A target's shapes (n + h,), their box (4, F), and the shapes (F, n + h) whose boxes overlap
    it and that are nearer than its farthest part.
    """

    own: NDArray[np.bool_]
    box: Floats
    over: NDArray[np.bool_]


def _spans(paints: NDArray[np.uint8], depths_m: Floats, boxes: Floats) -> list[_Span | None]:
    """The spans of the targets, None of a target without shapes."""
    spans: list[_Span | None] = []
    for target in range(T):
        own = paints == TARGET_PAINT + target
        if not own.any():
            spans.append(None)
            continue
        shapes = np.flatnonzero(own)
        mine = boxes[:, :, shapes]
        box = np.concatenate([mine[:2].min(axis=2), mine[2:].max(axis=2)])
        over = (boxes[0] < box[2, :, None]) & (boxes[2] > box[0, :, None])
        over &= (boxes[1] < box[3, :, None]) & (boxes[3] > box[1, :, None])
        over &= depths_m < depths_m[:, shapes].max(axis=1)[:, None]
        spans.append(_Span(own, box, over))
    return spans


def _matters(paints: NDArray[np.uint8], spans: list[_Span | None]) -> NDArray[np.bool_]:
    """Skin, and what may lie over a target (F, n + h)."""
    out = (paints >= TARGET_PAINT) | (paints == BARE)
    for span in spans:
        if span is not None:
            out = out | span.over
    return np.asarray(out)


def _targets(
    spans: list[_Span | None], frames: int, size: tuple[int, int]
) -> tuple[list[tuple[Box, ...]], list[list[bool]]]:
    """Boxes of the targets, and whether a nearer shape's box overlaps them, per frame."""
    boxes: list[list[Box]] = []
    covers: list[NDArray[np.bool_]] = []
    for span in spans:
        if span is None:
            boxes.append([(0, 0, 0, 0)] * frames)
            covers.append(np.zeros(frames, bool))
            continue
        covers.append(np.asarray((span.over & ~span.own).any(axis=1)))
        around = np.concatenate([np.floor(span.box[:2]) - 1, np.ceil(span.box[2:]) + 2])
        boxes.append(_whole(around, size))
    return list(zip(*boxes, strict=True)), np.stack(covers, axis=1).tolist()


def _skin_boxes(paints: NDArray[np.uint8], boxes: Floats, size: tuple[int, int]) -> list[Box]:
    """A box around all skin of each frame."""
    mine = boxes[:, :, paints >= BARE]
    low, high = mine[:2].min(axis=2), mine[2:].max(axis=2)
    # Corners of a round end lie up to 0.0427 of its radius outside it.
    air = 4.0 + 0.05 * (high - low).max(axis=0)
    low, high = 2.0 * np.floor((low - air) / 2.0), np.ceil(high + air)
    return _whole(np.concatenate([low, high]), size)


def _whole(boxes: Floats, size: tuple[int, int]) -> list[Box]:
    """Boxes (4, F) of whole numbers, cut to the picture."""
    height, width = size
    inside = np.clip(boxes, 0, np.array([[width], [height], [width], [height]])).astype(int)
    return list(zip(*inside.tolist(), strict=True))
