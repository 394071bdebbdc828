"""Labels as colour pictures: depth, instance ids, amodal masks, disparity, occlusion."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Image
from pjpdaf.camera import StereoRig
from pjpdaf.targets import TARGETS
from sim.dataset.labels.instances import FIRST_OBJECT, NOTHING, PERSON, ROOM, TABLE
from sim.dataset.labels.records import HIDDEN, NO_SURFACE, OUT_OF_FRAME, SEEN

Colour = tuple[int, int, int]

FULL_FLOW_PX = 40.0  # of the brightest colour of flow
NEAR_M, FAR_M = 0.5, 4.0  # red and blue; in between the colour goes with 1 / depth
EMPTY: Colour = (38, 34, 32)
# BGR; distinct for the colour-blind as well, and bright on a dark picture.
TARGET_COLOURS: tuple[Colour, ...] = ((94, 143, 255), (160, 220, 63), (255, 189, 116))
_SURFACES = {NOTHING: EMPTY, PERSON: (120, 96, 128), TABLE: (70, 96, 120), ROOM: (84, 80, 78)}
_OBJECTS: tuple[Colour, ...] = (
    (60, 220, 250),
    (200, 120, 240),
    (120, 220, 240),
    (220, 210, 90),
    (110, 130, 250),
)
_STATUS: dict[int, Colour] = {
    NO_SURFACE: EMPTY,
    SEEN: (96, 92, 90),
    HIDDEN: (60, 150, 250),
    OUT_OF_FRAME: (235, 170, 80),
}
_HATCH_PX = 6


def depth_picture(depth_m: NDArray[np.float32]) -> Image:
    """Colour planar z (h, w) [m] by nearness (h, w, 3) BGR; NaN, no surface, is dark."""
    near, far = 1 / NEAR_M, 1 / FAR_M
    known = np.isfinite(depth_m)
    return _turbo((1 / np.where(known, depth_m, 1.0) - far) / (near - far), known)


def disparity_picture(disparity_px: NDArray[np.float32], most_px: float) -> Image:
    """Colour disparity (h, w) [px] (h, w, 3) BGR, red at `most_px`; NaN, none, is dark."""
    known = np.isfinite(disparity_px)
    return _turbo(np.where(known, disparity_px, 0.0) / most_px, known)


def most_disparity_px(rig: StereoRig) -> float:
    """Disparity [px] of a surface at NEAR_M, for the same colours as its depth."""
    baseline_m = float(np.linalg.norm(rig.right.centre_w - rig.left.centre_w))
    return max(float(rig.left.K[0, 0]) * baseline_m / NEAR_M, 1.0)


def seg_picture(seg: Image) -> Image:
    """Colour instance ids (h, w) as (h, w, 3) BGR; targets have fixed colours."""
    return np.asarray(_palette()[seg])


def instance_colour(identity: int) -> Colour:
    """The colour of an instance id, BGR."""
    b, g, r = _palette()[identity].tolist()
    return b, g, r


def classes_picture(classes: Image) -> Image:
    """Colour semantic classes (h, w) as (h, w, 3) BGR, by turns of the golden angle."""
    hues = (np.arange(256) * 137.508 / 2) % 180
    hsv = np.stack([hues, np.full(256, 110.0), np.full(256, 210.0)], axis=-1).astype(np.uint8)
    table = cv2.cvtColor(hsv[None], cv2.COLOR_HSV2BGR)[0]
    table[0] = EMPTY
    return np.asarray(table[classes])


def normals_picture(normals: NDArray[np.float32]) -> Image:
    """Colour normals (h, w, 3) as is usual: red right, green up, blue towards the camera."""
    known = np.isfinite(normals).all(axis=-1, keepdims=True)
    towards = np.where(known, normals, 0) * np.array([1.0, -1.0, -1.0])
    picture = np.rint(127.5 * (1 + towards[..., ::-1])).astype(np.uint8)
    return np.where(known, picture, np.array(EMPTY, np.uint8))


def flow_picture(places_px: NDArray[np.float32], status: Image) -> Image:
    """Colour flow (h, w, 2) by its direction, dark where nothing moves; hidden pixels as status."""
    height, width = status.shape
    rows, columns = np.mgrid[:height, :width]
    dx, dy = np.nan_to_num(places_px[..., 0] - columns), np.nan_to_num(places_px[..., 1] - rows)
    hue = (np.degrees(np.arctan2(dy, dx)) + 180) / 2
    value = 40 + 215 * np.clip(np.hypot(dx, dy) / FULL_FLOW_PX, 0, 1)
    hsv = np.stack([hue, np.full_like(hue, 190), value], axis=-1).astype(np.uint8)
    picture = np.asarray(cv2.cvtColor(hsv, cv2.COLOR_HSV2BGR), np.uint8)
    other = status != SEEN
    picture[other] = occlusion_picture(status)[other]
    return picture


def occlusion_picture(status: Image) -> Image:
    """Colour the status (h, w) of `Matches` (h, w, 3) BGR: grey seen, orange hidden, blue out."""
    table = np.full((256, 3), EMPTY, np.uint8)
    for value, colour in _STATUS.items():
        table[value] = colour
    return np.asarray(table[status])


def amodal_picture(picture: Image, amodal: NDArray[np.bool_], seg: Image | None) -> Image:
    """Draw amodal masks (T, h, w) over the dimmed picture (h, w, 3) BGR.

    Each is outlined, filled where the target shows and striped where the ids in `seg` (h, w), if
    given, show another instance.
    """
    canvas = (picture.astype(np.float32) * 0.45).astype(np.uint8)
    height, width = canvas.shape[:2]
    ys, xs = np.mgrid[:height, :width]
    stripes = (xs + ys) % _HATCH_PX < _HATCH_PX // 2
    for target, (mask, colour) in enumerate(zip(amodal, TARGET_COLOURS, strict=True)):
        visible = mask if seg is None else mask & (seg == 1 + target)
        inked = visible | (mask & ~visible & stripes)
        mixed = 0.45 * canvas[inked] + 0.55 * np.array(colour)
        canvas[inked] = mixed.astype(np.uint8)
        edge = mask ^ cv2.erode(mask.astype(np.uint8), np.ones((3, 3), np.uint8)).astype(bool)
        canvas[edge] = colour
    return canvas


def _turbo(share: NDArray[Any], known: NDArray[np.bool_]) -> Image:
    grey = (np.clip(share, 0.0, 1.0) * 255).round().astype(np.uint8)
    coloured = np.asarray(cv2.applyColorMap(grey, cv2.COLORMAP_TURBO), np.uint8)
    coloured[~known] = EMPTY
    return coloured


def _palette() -> Image:
    table = np.full((256, 3), (110, 110, 110), np.uint8)
    for identity, colour in _SURFACES.items():
        table[identity] = colour
    for target in range(len(TARGETS)):
        table[1 + target] = TARGET_COLOURS[target]
    for identity in range(FIRST_OBJECT, 256):
        table[identity] = _OBJECTS[(identity - FIRST_OBJECT) % len(_OBJECTS)]
    return table
