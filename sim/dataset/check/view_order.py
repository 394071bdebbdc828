"""Which eye a picture is of: found from the pictures and the depth, without rendering.

A surface point has the same colour in both pictures, where depth says it lies in them. If left and
right are exchanged it has not: all moves by twice the disparity. Compared are the two hypotheses on
the same pixels, after a blur that takes most of the noise: light, noise and JPEG act on both alike.
"""

from __future__ import annotations

import cv2
import numpy as np

from pjpdaf.arrays import Floats, Image
from sim.dataset.check.depth import STILL, Crossing
from sim.dataset.check.fault import Fault
from sim.dataset.check.frame import Frame
from sim.scene.world import CAMERAS

BLUR_PX = 5
FEW = 50  # points that both views show
# The residual of the wrong hypothesis was 3.4 to 16 times that of the right one in 12 data sets
# (noise 12, 1.5 EV under, blur, JPEG 60, walls near skin, 160 x 120).
RATIO = 0.7


def views_swapped(pictures: tuple[Image, Image], crossing: Crossing) -> bool:
    """Whether left and right picture are each other's; crossing: from left to right."""
    if len(crossing.places_px) < FEW:
        return False
    here = np.column_stack(crossing.at[::-1]).astype(np.float64)
    left, right = (cv2.blur(picture, (BLUR_PX, BLUR_PX)) for picture in pictures)
    straight = _residual(left, here, right, crossing.places_px)
    crossed = _residual(right, here, left, crossing.places_px)
    return crossed < RATIO * straight


def exchanged_faults(frame: Frame, crossing: Crossing, kind: str = "") -> list[Fault]:
    """Of the pictures of a frame, or of its clean ones."""
    pictures = [eye.clean if kind == "clean" else eye.picture for eye in frame.eyes]
    if pictures[0] is None or pictures[1] is None:
        return []
    if not views_swapped((pictures[0], pictures[1]), crossing):
        return []
    return [Fault(frame.file(kind, v), wrong_eye(v)) for v in (0, 1)]


def wrong_eye(view: int) -> str:
    """What is said of a picture in this view's place."""
    return f"is a picture of the {CAMERAS[1 - view]} camera"


def lone_fault(frame: Frame, view: int, backgrounds: tuple[Image, Image]) -> list[Fault]:
    """Of a picture whose other eye did not arrive: which eye's background does it have?"""
    eye = frame.eyes[view]
    if eye.picture is None or eye.seg is None:
        return []
    still = np.isin(eye.seg, STILL)
    if np.count_nonzero(still) < FEW:
        return []
    own, other = (
        cv2.absdiff(*(cv2.blur(p, (BLUR_PX, BLUR_PX)) for p in (eye.picture, background)))[still]
        for background in (backgrounds[view], backgrounds[1 - view])
    )
    if other.mean() < RATIO * own.mean():
        return [Fault(frame.file("", view), wrong_eye(view))]
    return []


def _residual(first: Image, at: Floats, second: Image, places_px: Floats) -> float:
    return float(cv2.absdiff(_sampled(first, at), _sampled(second, places_px)).mean())


def _sampled(picture: Image, at: Floats) -> Image:
    x, y = np.ascontiguousarray(at.T, np.float32)
    found: Image = cv2.remap(picture, x[None], y[None], cv2.INTER_LINEAR)
    return found
