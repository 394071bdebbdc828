"""A stereo pair with its exact truth drawn on it."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import cv2
import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Floats, Image
from pjpdaf.camera import Camera, distort_points, project
from pjpdaf.frames import StereoFrame
from reports.pictures.overlay import (
    BLACK,
    LETTERS,
    NAMES,
    STRIP,
    WHITE,
    YELLOW,
    canvas_of,
    draw_cross,
    draw_curve,
    draw_text,
    ellipse_points,
    side_by_side,
    text_width,
)
from sim.truth import Truth, ViewTruth

Labels = NDArray[np.int8]
STRIP_PX = 56
# BGR, those of the dark page: the scenes are dark as well.
_COLOURS = ((115, 125, 255), (131, 207, 88), (255, 159, 142))
_MARGIN_PX = 40  # about the targets on a thumbnail
_LINE_PX = 19  # between two labels
_HIDDEN_PX = 11.0  # radius of the ring about a target that does not show


def truth_picture(
    frame: StereoFrame,
    cameras: Sequence[Camera],
    labels: Sequence[Labels],
    truth: Truth,
    trails_m: Sequence[Floats],
    title: str = "",
) -> Image:
    """All views side by side (h, w, 3) BGR with the truth, and a strip below.

    frame: the pictures as filmed; a missing one is grey and has no truth on it. labels: per view
    the target of each pixel (h, w), -1 none. trails_m: per view where the targets' centres have
    been (n, T, 3), world, oldest first, the last at the moment of that view's exposure.

    Outline: the visible skin. Cross: the projected 3-D centre; a ring where nothing of the target
    shows. Beside it its letter and how much of its skin is visible. Yellow: merged in this view.
    Strip: frame, time, legend, events, title.
    """
    views = []
    for v, (picture, camera) in enumerate(zip(frame.pictures, cameras, strict=True)):
        canvas = canvas_of(picture, camera)
        if picture is not None:
            centres_px = _real_pixels(camera, trails_m[v][-1])
            draw_outlines(canvas, labels[v], thickness_px=2)
            _draw_trail(canvas, camera, trails_m[v])
            _draw_merged(canvas, truth.views[v], centres_px)
            _draw_centres(canvas, truth.views[v], centres_px)
            _draw_labels(canvas, truth.views[v], centres_px)
        views.append(canvas)
    body = side_by_side(views)
    return np.vstack([body, _strip(body.shape[1], truth, title)])


def thumbnail(
    frame: StereoFrame,
    cameras: Sequence[Camera],
    labels: Sequence[Labels],
    truth: Truth,
    side_px: int,
) -> Image:
    """The part about the targets of all views, squares side by side, with outlines and letters.

    All views show the same part, so that the disparity stays. Arguments as in `truth_picture`.
    """
    left, side = _part_about(cameras, truth)
    views = []
    for v, (picture, camera) in enumerate(zip(frame.pictures, cameras, strict=True)):
        size = (side_px, round(side_px * min(camera.height_px, side) / side))
        part = (slice(None), slice(left, left + side))
        whole = canvas_of(picture, camera)[part]
        canvas = np.asarray(cv2.resize(whole, size, interpolation=cv2.INTER_AREA), dtype=np.uint8)
        if picture is not None:
            mask = cv2.resize(labels[v][part], size, interpolation=cv2.INTER_NEAREST)
            draw_outlines(canvas, mask, thickness_px=1, halo=False)
            for t, letter in enumerate(LETTERS):
                ys, xs = np.nonzero(mask == t)
                if len(xs):
                    at = (min(int(xs.max()) + 4, side_px - 16), max(int(ys.min()) + 12, 16))
                    draw_text(canvas, letter, at, _COLOURS[t])
        square = np.full((side_px, side_px, 3), STRIP, dtype=np.uint8)
        above = (side_px - size[1]) // 2  # a picture lower than wide: bars
        square[above : above + size[1]] = canvas
        views.append(square)
    return side_by_side(views)


def _part_about(cameras: Sequence[Camera], truth: Truth) -> tuple[int, int]:
    """First column and side of the square about all targets: the picture's height, or wider."""
    width = min(camera.width_px for camera in cameras)
    height = min(camera.height_px for camera in cameras)
    edges_px = []
    for camera, shown in zip(cameras, truth.views, strict=True):
        for x, box in zip(_real_pixels(camera, truth.centres_m)[:, 0], shown.boxes_px, strict=True):
            edges_px += [box[0], box[0] + box[2]] if np.isfinite(box[0]) else [x, x]
    edges = np.clip(np.nan_to_num(edges_px, nan=width / 2), 0, width)
    side = int(min(width, max(height, np.ptp(edges) + 2 * _MARGIN_PX)))
    left = (edges.min() + edges.max() - side) / 2
    return int(np.clip(left, 0, width - side)), side


def draw_outlines(canvas: Image, labels: Labels, thickness_px: int, halo: bool = True) -> None:
    """A line around every target's visible skin in its colour: it covers no skin of its own."""
    masks = [(labels == t).astype(np.uint8) for t in range(len(LETTERS))]
    lines = [_grown(mask, thickness_px) > mask for mask in masks]
    if halo:
        for mask, line in zip(masks, lines, strict=True):
            canvas[(_grown(mask, thickness_px + 1) > mask) & ~line] = BLACK
    for line, colour in zip(lines, _COLOURS, strict=True):
        canvas[line] = colour


def _grown(mask: NDArray[np.uint8], by_px: int) -> NDArray[np.uint8]:
    kernel = np.ones((2 * by_px + 1, 2 * by_px + 1), np.uint8)
    return np.asarray(cv2.dilate(mask, kernel), dtype=np.uint8)


def _real_pixels(camera: Camera, points_m: Floats) -> Floats:
    """Pixels (n, 2) of the real picture, NaN behind the camera."""
    ideal = project(camera, points_m.reshape(-1, 3))
    real = np.full_like(ideal, np.nan)
    ahead = np.isfinite(ideal[:, 0])
    real[ahead] = distort_points(camera, ideal[ahead])
    return real


def _draw_trail(canvas: Image, camera: Camera, trail_m: Floats) -> None:
    T = trail_m.shape[1]
    pixels = _real_pixels(camera, trail_m).reshape(-1, T, 2)
    for t, colour in enumerate(_COLOURS):
        path = pixels[np.isfinite(pixels[:, t, 0]), t]
        if len(path) > 1:
            draw_curve(canvas, path, colour, 1, closed=False)


def _draw_merged(canvas: Image, shown: ViewTruth, centres_px: Floats) -> None:
    for a, b in _pairs(shown):
        ends = np.stack([_place(shown, centres_px, a), _place(shown, centres_px, b)])
        draw_curve(canvas, ends, YELLOW, 2, closed=False)
    pairs = merged_text(shown)
    if pairs:
        draw_text(canvas, f"merged {pairs}", (10, 24), YELLOW)


def _draw_centres(canvas: Image, shown: ViewTruth, centres_px: Floats) -> None:
    for t, colour in enumerate(_COLOURS):
        if not np.isfinite(centres_px[t]).all():
            continue
        if shown.visible_px[t]:
            draw_cross(canvas, centres_px[t], colour)
        else:
            draw_curve(canvas, ellipse_points(centres_px[t], _HIDDEN_PX, _HIDDEN_PX, 0), colour, 2)


def _draw_labels(canvas: Image, shown: ViewTruth, centres_px: Floats) -> None:
    """Letter and visible share beside each target; no label on another."""
    height, width = canvas.shape[:2]
    taken: list[tuple[int, int, int]] = []
    for t, colour in enumerate(_COLOURS):
        place = _place(shown, centres_px, t)
        if not np.isfinite(place).all():
            continue
        text = f"{LETTERS[t]} {visible_text(shown, t)}"
        long_px = text_width(text)
        half = shown.boxes_px[t, 2] / 2 if shown.visible_px[t] else _HIDDEN_PX
        x = int(np.clip(place[0] + half + 8, 4, max(4, width - long_px - 6)))
        y = int(np.clip(place[1] - 4, 46, height - 8))
        while any(abs(y - v) < _LINE_PX and x < u + n and u < x + long_px for u, v, n in taken):
            y += 1
        taken.append((x, y, long_px))
        draw_text(canvas, text, (x, y), colour)


def visible_text(shown: ViewTruth, target: int) -> str:
    """The visible share of a target's skin in a view: "87 %", "hidden", "out of view"."""
    if shown.amodal_px[target] == 0:
        return "out of view"
    if shown.visible_px[target] == 0:
        return "hidden"
    return f"{max(1, int(100 * shown.visible_fractions[target]))} %"


def merged_text(shown: ViewTruth) -> str:
    """The pairs of targets merged in a view, such as "R+L"; empty without any."""
    return ", ".join(f"{LETTERS[a]}+{LETTERS[b]}" for a, b in _pairs(shown))


def _pairs(shown: ViewTruth) -> list[tuple[int, int]]:
    return [(a, b) for a, b in combinations(range(len(LETTERS)), 2) if shown.merged[a, b]]


def _place(shown: ViewTruth, centres_px: Floats, target: int) -> Floats:
    """Middle of the visible skin, else the projected centre (2,)."""
    centroid = shown.centroids_px[target]
    return np.asarray(centroid if np.isfinite(centroid).all() else centres_px[target])


def _strip(width: int, truth: Truth, title: str) -> Image:
    """Frame and time, legend (where there is room), events, title."""
    strip = np.full((STRIP_PX, width, 3), STRIP, dtype=np.uint8)
    draw_text(strip, f"frame {truth.index}   {truth.time_s:.2f} s", (12, 21), WHITE)
    if width >= 1000:
        x = 260
        draw_text(strip, "truth:", (x, 21), WHITE)
        x += 70
        for text, colour in zip(NAMES, _COLOURS, strict=True):
            draw_text(strip, text, (x, 21), colour)
            x += text_width(text) + 22
        for text, colour in (("% of its skin visible", WHITE), ("merged", YELLOW)):
            draw_text(strip, text, (x, 21), colour)
            x += text_width(text) + 22
    title = fitting(title, width // 2)
    right = width - 12 - text_width(title)
    draw_text(strip, title, (right, 46), WHITE)
    draw_text(strip, fitting(script_text(truth), right - 36), (12, 46), WHITE)
    return strip


def script_text(truth: Truth) -> str:
    """The script's events of the frame; merges are drawn instead."""
    return ", ".join(truth.script_events)


def fitting(text: str, width_px: int) -> str:
    """Shorten a text to this width as `draw_text` draws it."""
    if text_width(text) <= width_px:
        return text
    while text and text_width(text + "...") > width_px:
        text = text[:-1]
    return text + "..."
