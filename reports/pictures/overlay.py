"""Both views with detections, estimates and truth drawn in (thesis Fig. 4.1, 4.5, 4.7)."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from pjpdaf.arrays import Floats, Image
from pjpdaf.camera import Camera, distort_points, project, projection_jacobian
from pjpdaf.frames import StereoFrame
from pjpdaf.interfaces import Detections, Estimates
from pjpdaf.targets import COLOURS_RGB
from reports.pictures.encode import jpeg_of
from sim.truth import Truth

LETTERS = ("H", "R", "L")  # beside each circle: colour is never the only sign
NAMES = ("H head", "R right hand", "L left hand")
QUALITY = 85
Colour = tuple[int, int, int]
YELLOW: Colour = (60, 225, 255)
BLACK: Colour = (0, 0, 0)
WHITE: Colour = (245, 245, 245)
STRIP: Colour = (34, 30, 28)
COLOURS: tuple[Colour, ...] = tuple((b, g, r) for r, g, b in COLOURS_RGB)
SHIFT = 4  # OpenCV draws at 1/16 px
_FONT = cv2.FONT_HERSHEY_SIMPLEX


def overlay_jpeg(
    frame: StereoFrame,
    cameras: Sequence[Camera],
    detections: Sequence[Detections],
    estimates: Estimates,
    truth: Truth | None = None,
    *,
    covariances: bool = False,
) -> bytes:
    """`overlay_picture` as JPEG."""
    sheet = overlay_picture(frame, cameras, detections, estimates, truth, covariances=covariances)
    return encode_jpeg(sheet)


def overlay_picture(
    frame: StereoFrame,
    cameras: Sequence[Camera],
    detections: Sequence[Detections],
    estimates: Estimates,
    truth: Truth | None = None,
    *,
    covariances: bool = False,
) -> Image:
    """Draw all views side by side (h, w, 3) BGR, with a legend below.

    frame: the pictures as filmed; detections: per view, may be empty. Detections and estimates are
    in undistorted pixels; the camera's lens bends them to match the pictures.

    Detected ellipses: thin yellow. Estimates: circles with a letter, red head, green right hand,
    blue left hand; lost or coasting ones are thin. Truth (the visible skin's centroid, else the
    projected centre): crosses; without truth, as of real footage, the strip says each target's
    status instead. covariances: 2-sigma ellipses of the estimates too.
    """
    views = []
    for v, (picture, camera) in enumerate(zip(frame.pictures, cameras, strict=True)):
        canvas = canvas_of(picture, camera)
        if v < len(detections):
            _draw_detections(canvas, camera, detections[v])
        if truth is not None:
            _draw_truth(canvas, camera, truth, v)
        _draw_estimates(canvas, camera, estimates, covariances)
        views.append(canvas)
    body = side_by_side(views)
    return np.vstack([body, _strip(body.shape[1], frame, estimates, truth)])


def side_by_side(views: Sequence[Image]) -> Image:
    """Put pictures (h, w, 3) in a row, a thin bar between them, low pictures filled up below."""
    height = max(view.shape[0] for view in views)
    padded = [np.pad(view, ((0, height - view.shape[0]), (0, 0), (0, 0))) for view in views]
    gap = np.full((height, 4, 3), STRIP, dtype=np.uint8)
    return np.hstack([part for view in padded for part in (view, gap)][:-1])


def encode_jpeg(sheet: Image) -> bytes:
    """Encode a picture (h, w, 3) BGR as JPEG of the overlays' quality."""
    return jpeg_of(sheet, QUALITY)


def canvas_of(picture: np.ndarray | None, camera: Camera) -> Image:
    """Copy the picture to draw on; a missing picture becomes a grey canvas with a note."""
    if picture is not None:
        return np.array(picture, dtype=np.uint8)
    canvas = np.full((camera.height_px, camera.width_px, 3), 60, dtype=np.uint8)
    draw_text(canvas, "picture missing", (20, camera.height_px // 2), WHITE)
    return canvas


def fixed(point: Floats) -> tuple[int, int]:
    """A pixel (2,) in OpenCV's fixed point of `SHIFT` bits."""
    x, y = np.clip(np.round(point * (1 << SHIFT)), -(1 << 26), 1 << 26)
    return int(x), int(y)


def draw_curve(
    canvas: Image, points_px: Floats, colour: Colour, thickness: int, closed: bool = True
) -> None:
    """Straight lines through pixels (n, 2), with a dark halo."""
    at = np.clip(np.round(points_px * (1 << SHIFT)), -(1 << 26), 1 << 26).astype(np.int32)
    for width, ink in ((thickness + 2, BLACK), (thickness, colour)):
        cv2.polylines(canvas, [at.reshape(-1, 1, 2)], closed, ink, width, cv2.LINE_AA, SHIFT)


def ellipse_points(centre: Floats, a: float, b: float, angle_rad: float) -> Floats:
    """48 pixels (48, 2) of an ellipse with half axes a, b."""
    phase = np.linspace(0, 2 * np.pi, 48, endpoint=False)
    c, s = np.cos(angle_rad), np.sin(angle_rad)
    turn = np.array([[c, -s], [s, c]])
    return np.asarray(centre + np.column_stack([a * np.cos(phase), b * np.sin(phase)]) @ turn.T)


def _draw_detections(canvas: Image, camera: Camera, detections: Detections) -> None:
    for x, y, a, b, angle in detections.ellipses:
        outline = ellipse_points(np.array([x, y]), a, b, angle)
        draw_curve(canvas, distort_points(camera, outline), YELLOW, 1)
    for centre in distort_points(camera, detections.centres_px):
        cv2.circle(canvas, fixed(centre), 2 << SHIFT, YELLOW, -1, cv2.LINE_AA, SHIFT)


def _draw_truth(canvas: Image, camera: Camera, truth: Truth, view: int) -> None:
    marks = truth.views[view].centroids_px
    marks = np.where(np.isfinite(marks), marks, project(camera, truth.centres_m))
    for mark, colour in zip(marks, COLOURS, strict=True):
        if np.isfinite(mark).all():
            draw_cross(canvas, distort_points(camera, mark)[0], colour)


def draw_cross(canvas: Image, at: Floats, colour: Colour, arm_px: float = 7.0) -> None:
    """A cross about a pixel (2,), with a dark halo."""
    for width, ink in ((4, BLACK), (2, colour)):
        for half in (np.array([arm_px, 0.0]), np.array([0.0, arm_px])):
            ends = fixed(at - half), fixed(at + half)
            cv2.line(canvas, *ends, ink, width, cv2.LINE_AA, SHIFT)


def _draw_estimates(canvas: Image, camera: Camera, estimates: Estimates, covariances: bool) -> None:
    pixels = project(camera, estimates.positions_m)
    for t, colour in enumerate(COLOURS):
        if not np.isfinite(pixels[t]).all():
            continue
        at = distort_points(camera, pixels[t])[0]
        width = 2 if estimates.status[t] == "tracked" else 1
        draw_curve(canvas, ellipse_points(at, 15.0, 15.0, 0.0), colour, width)
        if covariances and np.isfinite(estimates.covariances_m2[t]).all():
            J = projection_jacobian(camera, estimates.positions_m[t])
            values, vectors = np.linalg.eigh(J @ estimates.covariances_m2[t] @ J.T)
            minor, major = 2 * np.sqrt(np.maximum(values, 0))
            angle = float(np.arctan2(vectors[1, 1], vectors[0, 1]))
            draw_curve(canvas, ellipse_points(at, float(major), float(minor), angle), colour, 1)
        if 0 <= at[0] < canvas.shape[1] and 0 <= at[1] < canvas.shape[0]:
            x = min(int(at[0]) + 18, canvas.shape[1] - 16)
            draw_text(canvas, LETTERS[t], (x, max(int(at[1]) - 8, 14)), colour)


def draw_text(
    canvas: Image, text: str, at: tuple[int, int], colour: Colour, size: float = 0.55
) -> None:
    """Words from a pixel on their base line, with a dark halo."""
    # The halo is made of shifted copies: a thicker font is a wider one in OpenCV 5.
    x, y = at
    for dx, dy in ((-1, -1), (-1, 1), (1, -1), (1, 1), (0, 2), (2, 0), (-2, 0), (0, -2)):
        cv2.putText(canvas, text, (x + dx, y + dy), _FONT, size, BLACK, 2, cv2.LINE_AA)
    cv2.putText(canvas, text, at, _FONT, size, colour, 2, cv2.LINE_AA)


def text_width(text: str, size: float = 0.55) -> int:
    """Width [px] of a text as `draw_text` draws it."""
    (width, _), _ = cv2.getTextSize(text, _FONT, size, 2)
    return int(width)


def _strip(width: int, frame: StereoFrame, estimates: Estimates, truth: Truth | None) -> Image:
    """Frame number, time and legend; the legend is left out where there is no room for it."""
    strip = np.full((30, width, 3), STRIP, dtype=np.uint8)
    draw_text(strip, f"frame {frame.index}   {frame.time_s:.2f} s", (12, 20), WHITE)
    if width < 900:
        return strip
    x = 250
    draw_curve(strip, ellipse_points(np.array([x, 15.0]), 10, 6, 0.0), YELLOW, 1)
    draw_text(strip, "detected", (x + 18, 20), WHITE)
    x += 130
    if truth is not None:
        for half in (np.array([6.0, 0.0]), np.array([0.0, 6.0])):
            at = np.array([float(x), 15.0])
            cv2.line(strip, fixed(at - half), fixed(at + half), WHITE, 2, cv2.LINE_AA, SHIFT)
        draw_text(strip, "truth", (x + 16, 20), WHITE)
        x += 100
        draw_text(strip, "estimates:", (x, 20), WHITE)
        x += 112
    for t, (text, colour) in enumerate(zip(NAMES, COLOURS, strict=True)):
        draw_curve(strip, ellipse_points(np.array([x, 15.0]), 8, 8, 0.0), colour, 2)
        label = text if truth is not None else f"{text} {estimates.status[t]}"
        draw_text(strip, label, (x + 16, 20), WHITE)
        x += (140 if truth is not None else 225) - (40 if t == 0 else 0)
    return strip
