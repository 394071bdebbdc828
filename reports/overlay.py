"""Both views side by side with what was seen, believed and true (thesis Fig. 4.1, 4.5, 4.7)."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Floats
from pjpdaf.camera import Camera, distort_points, project, projection_jacobian
from pjpdaf.frames import StereoFrame
from pjpdaf.interfaces import Detections, Estimates
from pjpdaf.targets import COLOURS_RGB
from sim.truth import Truth

LETTERS = ("H", "R", "L")  # beside each circle: colour is never the only sign
_NAMES = ("H head", "R right hand", "L left hand")
QUALITY = 85
_Image = NDArray[np.uint8]
_Colour = tuple[int, int, int]
_YELLOW: _Colour = (60, 225, 255)
_BLACK: _Colour = (0, 0, 0)
_WHITE: _Colour = (245, 245, 245)
_STRIP: _Colour = (34, 30, 28)
_COLOURS: tuple[_Colour, ...] = tuple((b, g, r) for r, g, b in COLOURS_RGB)
_SHIFT = 4  # OpenCV draws at 1/16 px
_FONT = cv2.FONT_HERSHEY_SIMPLEX


def overlay_jpeg(
    frame: StereoFrame,
    cameras: Sequence[Camera],
    seen: Sequence[Detections],
    estimates: Estimates,
    truth: Truth | None = None,
    *,
    covariances: bool = False,
) -> bytes:
    """`overlay_picture` as JPEG."""
    sheet = overlay_picture(frame, cameras, seen, estimates, truth, covariances=covariances)
    return encode_jpeg(sheet)


def overlay_picture(
    frame: StereoFrame,
    cameras: Sequence[Camera],
    seen: Sequence[Detections],
    estimates: Estimates,
    truth: Truth | None = None,
    *,
    covariances: bool = False,
) -> _Image:
    """All views side by side (h, w, 3) BGR, with a strip below that says what is what.

    frame: the pictures as filmed; seen: per view, may be empty. All of it is in undistorted pixels
    and is bent by the camera's lens to match the pictures.

    Detected ellipses: thin yellow. Estimates: circles with a letter, red head, green right hand,
    blue left hand; lost or coasting ones are thin. Truth (the visible skin's centroid, else the
    projected centre): crosses; without truth, as of real footage, the strip says each target's
    status instead. covariances: 2-sigma ellipses of the estimates too.
    """
    views = []
    for v, (picture, camera) in enumerate(zip(frame.pictures, cameras, strict=True)):
        canvas = _canvas(picture, camera)
        if v < len(seen):
            _draw_detections(canvas, camera, seen[v])
        if truth is not None:
            _draw_truth(canvas, camera, truth, v)
        _draw_estimates(canvas, camera, estimates, covariances)
        views.append(canvas)
    height = max(view.shape[0] for view in views)
    views = [_padded(view, height) for view in views]
    gap = np.full((height, 4, 3), _STRIP, dtype=np.uint8)
    body = np.hstack([part for view in views for part in (view, gap)][:-1])
    return np.vstack([body, _strip(body.shape[1], frame, estimates, truth)])


def encode_jpeg(sheet: _Image) -> bytes:
    """A BGR picture as JPEG."""
    done, jpeg = cv2.imencode(".jpg", sheet, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])
    assert done, "OpenCV always encodes a uint8 BGR picture"
    return bytes(jpeg)


def _canvas(picture: np.ndarray | None, camera: Camera) -> _Image:
    if picture is not None:
        return np.array(picture, dtype=np.uint8)
    canvas = np.full((camera.height_px, camera.width_px, 3), 60, dtype=np.uint8)
    _text(canvas, "picture missing", (20, camera.height_px // 2), _WHITE)
    return canvas


def _padded(view: _Image, height: int) -> _Image:
    return np.pad(view, ((0, height - view.shape[0]), (0, 0), (0, 0)))


def _fixed(point: Floats) -> tuple[int, int]:
    x, y = np.clip(np.round(point * (1 << _SHIFT)), -(1 << 26), 1 << 26)
    return int(x), int(y)


def _curve(canvas: _Image, points_px: Floats, colour: _Colour, thickness: int) -> None:
    fixed = np.clip(np.round(points_px * (1 << _SHIFT)), -(1 << 26), 1 << 26).astype(np.int32)
    for width, ink in ((thickness + 2, _BLACK), (thickness, colour)):
        cv2.polylines(canvas, [fixed.reshape(-1, 1, 2)], True, ink, width, cv2.LINE_AA, _SHIFT)


def _ellipse_points(centre: Floats, a: float, b: float, angle_rad: float) -> Floats:
    phase = np.linspace(0, 2 * np.pi, 48, endpoint=False)
    c, s = np.cos(angle_rad), np.sin(angle_rad)
    turn = np.array([[c, -s], [s, c]])
    return np.asarray(centre + np.column_stack([a * np.cos(phase), b * np.sin(phase)]) @ turn.T)


def _draw_detections(canvas: _Image, camera: Camera, seen: Detections) -> None:
    for x, y, a, b, angle in seen.ellipses:
        outline = _ellipse_points(np.array([x, y]), a, b, angle)
        _curve(canvas, distort_points(camera, outline), _YELLOW, 1)
    for centre in distort_points(camera, seen.centres_px):
        cv2.circle(canvas, _fixed(centre), 2 << _SHIFT, _YELLOW, -1, cv2.LINE_AA, _SHIFT)


def _draw_truth(canvas: _Image, camera: Camera, truth: Truth, view: int) -> None:
    marks = truth.views[view].centroids_px
    marks = np.where(np.isfinite(marks), marks, project(camera, truth.centres_m))
    arm = np.array([[7.0, 0.0], [0.0, 7.0]])
    for mark, colour in zip(marks, _COLOURS, strict=True):
        if np.isfinite(mark).all():
            at = distort_points(camera, mark)[0]
            for width, ink in ((4, _BLACK), (2, colour)):
                for half in arm:
                    ends = _fixed(at - half), _fixed(at + half)
                    cv2.line(canvas, *ends, ink, width, cv2.LINE_AA, _SHIFT)


def _draw_estimates(canvas: _Image, camera: Camera, said: Estimates, covariances: bool) -> None:
    pixels = project(camera, said.positions_m)
    for t, colour in enumerate(_COLOURS):
        if not np.isfinite(pixels[t]).all():
            continue
        at = distort_points(camera, pixels[t])[0]
        width = 2 if said.status[t] == "tracked" else 1
        _curve(canvas, _ellipse_points(at, 15.0, 15.0, 0.0), colour, width)
        if covariances and np.isfinite(said.covariances_m2[t]).all():
            J = projection_jacobian(camera, said.positions_m[t])
            values, vectors = np.linalg.eigh(J @ said.covariances_m2[t] @ J.T)
            minor, major = 2 * np.sqrt(np.maximum(values, 0))
            angle = float(np.arctan2(vectors[1, 1], vectors[0, 1]))
            _curve(canvas, _ellipse_points(at, float(major), float(minor), angle), colour, 1)
        if 0 <= at[0] < canvas.shape[1] and 0 <= at[1] < canvas.shape[0]:
            x = min(int(at[0]) + 18, canvas.shape[1] - 16)
            _text(canvas, LETTERS[t], (x, max(int(at[1]) - 8, 14)), colour)


def _text(canvas: _Image, words: str, at: tuple[int, int], colour: _Colour) -> None:
    # The halo is made of shifted copies: a thicker font is a wider one in OpenCV 5.
    x, y = at
    for dx, dy in ((-1, -1), (-1, 1), (1, -1), (1, 1), (0, 2), (2, 0), (-2, 0), (0, -2)):
        cv2.putText(canvas, words, (x + dx, y + dy), _FONT, 0.55, _BLACK, 2, cv2.LINE_AA)
    cv2.putText(canvas, words, at, _FONT, 0.55, colour, 2, cv2.LINE_AA)


def _strip(width: int, frame: StereoFrame, estimates: Estimates, truth: Truth | None) -> _Image:
    """Frame number, time and legend; the legend is left out where there is no room for it."""
    strip = np.full((30, width, 3), _STRIP, dtype=np.uint8)
    _text(strip, f"frame {frame.index}   {frame.time_s:.2f} s", (12, 20), _WHITE)
    if width < 900:
        return strip
    x = 250
    _curve(strip, _ellipse_points(np.array([x, 15.0]), 10, 6, 0.0), _YELLOW, 1)
    _text(strip, "detected", (x + 18, 20), _WHITE)
    x += 130
    if truth is not None:
        for half in (np.array([6.0, 0.0]), np.array([0.0, 6.0])):
            at = np.array([float(x), 15.0])
            cv2.line(strip, _fixed(at - half), _fixed(at + half), _WHITE, 2, cv2.LINE_AA, _SHIFT)
        _text(strip, "truth", (x + 16, 20), _WHITE)
        x += 100
        _text(strip, "estimates:", (x, 20), _WHITE)
        x += 112
    for t, (words, colour) in enumerate(zip(_NAMES, _COLOURS, strict=True)):
        _curve(strip, _ellipse_points(np.array([x, 15.0]), 8, 8, 0.0), colour, 2)
        said = words if truth is not None else f"{words} {estimates.status[t]}"
        _text(strip, said, (x + 16, 20), _WHITE)
        x += (140 if truth is not None else 225) - (40 if t == 0 else 0)
    return strip
