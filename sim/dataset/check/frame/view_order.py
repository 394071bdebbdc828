"""Whether the left and the right picture are swapped: from pictures and depth, without rendering.

A surface point has the same colour in both pictures, at the positions where depth projects it. If
left and right are swapped it has not: every point is off by twice the disparity. Both hypotheses
are compared on the same pixels, after a blur that removes most of the noise: light, noise and JPEG
act on both alike.
"""

from __future__ import annotations

from collections.abc import Iterator

import cv2
import numpy as np

from pjpdaf.arrays import Floats, Image
from sim.dataset.check.fault import Fault
from sim.dataset.check.frame.arrays import FrameArrays
from sim.dataset.check.frame.closing import Correspondences
from sim.dataset.check.frame.pixel_rays import positions
from sim.dataset.check.frame.view import FEW, is_static
from sim.scene.world import CAMERAS

BLUR_PX = 5
# The residual of the wrong hypothesis was 3.4 to 16 times that of the right one in 12 data sets
# (noise 12, 1.5 EV under, blur, JPEG 60, walls near skin, 160 x 120).
RATIO = 0.7


def views_swapped(pictures: tuple[Image, Image], matches: Correspondences) -> bool:
    """Whether left and right picture are swapped; matches: from left to right."""
    if len(matches.other_px) < FEW:
        return False
    here = positions(matches.at)
    left, right = (_blurred(picture) for picture in pictures)
    straight = _residual(left, here, right, matches.other_px)
    crossed = _residual(right, here, left, matches.other_px)
    return crossed < RATIO * straight


def check_view_order(
    frame: FrameArrays, matches: Correspondences, label: str = ""
) -> Iterator[Fault]:
    """Check a frame's pictures, or with the label "clean" its clean pictures."""
    left, right = (view.clean if label == "clean" else view.picture for view in frame.views)
    if left is None or right is None or not views_swapped((left, right), matches):
        return
    for view in (0, 1):
        yield wrong_view(frame.file(label, view), view)


def check_lone_view(
    frame: FrameArrays, view: int, backgrounds: tuple[Image, Image]
) -> Iterator[Fault]:
    """Check a picture whose partner did not arrive: it must match its own camera's background."""
    arrays = frame.views[view]
    if arrays.picture is None or arrays.seg is None:
        return
    static = is_static(arrays.seg)
    if np.count_nonzero(static) < FEW:
        return
    picture = _blurred(arrays.picture)
    own, other = (
        cv2.absdiff(picture, _blurred(backgrounds[v]))[static].mean() for v in (view, 1 - view)
    )
    if other < RATIO * own:
        yield wrong_view(frame.file("", view), view)


def wrong_view(file: str, view: int) -> Fault:
    """The fault of a picture of the other camera in this view's place."""
    return Fault(file, f"is a picture of the {CAMERAS[1 - view]} camera")


def _blurred(picture: Image) -> Image:
    blurred: Image = cv2.blur(picture, (BLUR_PX, BLUR_PX))
    return blurred


def _residual(first: Image, first_px: Floats, second: Image, second_px: Floats) -> float:
    difference = cv2.absdiff(_sampled(first, first_px), _sampled(second, second_px))
    return float(difference.mean())


def _sampled(picture: Image, pixels: Floats) -> Image:
    x, y = np.ascontiguousarray(pixels.T, np.float32)
    sampled: Image = cv2.remap(picture, x[None], y[None], cv2.INTER_LINEAR)
    return sampled
