"""A rectangle of a picture that is drawn, in place of all of it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.camera import Camera

_LEAST_DEPTH_M = 0.01  # what is nearer to the camera's plane has no bounded place in the picture


@dataclass(frozen=True)
class Window:
    """Columns left to right and rows top to bottom of a picture, ends excluded; may be empty."""

    left: int
    top: int
    right: int
    bottom: int

    @property
    def size(self) -> tuple[int, int]:
        """Height and width."""
        return max(self.bottom - self.top, 0), max(self.right - self.left, 0)

    @property
    def empty(self) -> bool:
        """Whether it has no pixel."""
        return 0 in self.size

    def crop(self, camera: Camera) -> Camera:
        """The camera whose picture is this window of an ideal camera's picture."""
        K = np.array(camera.K)
        K[:2, 2] -= self.left, self.top
        height, width = self.size
        return replace(camera, K=K, width_px=width, height_px=height)

    def within(self, width: int, height: int, step: int = 1) -> Window:
        """The part inside a picture, grown to multiples of `step` pixels."""
        left, top = (max(v // step * step, 0) for v in (self.left, self.top))
        right, bottom = (-(-v // step) * step for v in (self.right, self.bottom))
        return Window(left, top, min(right, width), min(bottom, height))

    def part(self, scale: int, from_below: int = 0) -> tuple[slice, slice]:
        """Index of its rows and columns in a picture `scale` times as fine.

        from_below: height of that picture, if its rows are counted from below.
        """
        top, bottom = self.top * scale, self.bottom * scale
        if from_below:
            top, bottom = from_below - bottom, from_below - top
        return slice(top, bottom), slice(self.left * scale, self.right * scale)


def whole(camera: Camera) -> Window:
    """All of a camera's picture."""
    return Window(0, 0, camera.width_px, camera.height_px)


@dataclass(frozen=True, eq=False)
class Bounds:
    """Ends (n,) [px] of what lies in boxes, in a picture, and its least planar depth [m].

    Infinite where a box reaches through the camera's plane: then it may be seen anywhere. Pixels
    are those whose area it touches; a box that is not seen ends before it begins.
    """

    left: Floats
    top: Floats
    right: Floats
    bottom: Floats
    near_m: Floats


def bounds_of(camera: Camera, boxes_w: Floats) -> Bounds:
    """Bounds of boxes (n, 8, 3), corners in the world, in an ideal camera's picture."""
    points = boxes_w @ camera.R_cw.T + camera.t_cw
    ahead = points[..., 2] > _LEAST_DEPTH_M
    image = points @ camera.K.T
    pixels = image[..., :2] / np.where(ahead, image[..., 2], 1.0)[..., None]
    through = ~ahead.all(axis=1)
    behind = ~ahead.any(axis=1)
    # A pixel reaches half a pixel around its centre; rounding may move an edge a little.
    low, high = pixels.min(axis=1) - 0.51, pixels.max(axis=1) + 0.51
    low[through], high[through] = -np.inf, np.inf
    low[behind], high[behind] = np.inf, -np.inf
    (left, top), (right, bottom) = low.T, high.T
    return Bounds(left, top, right, bottom, near_m=points[..., 2].min(axis=1))


def around(camera: Camera, boxes_w: Floats) -> Window:
    """The smallest window of an ideal camera's picture that holds what lies in boxes."""
    bounds = bounds_of(camera, boxes_w)
    width, height = camera.width_px, camera.height_px

    ends = (
        np.clip(np.ceil(bounds.left.min(initial=width)), 0, width),
        np.clip(np.ceil(bounds.top.min(initial=height)), 0, height),
        np.clip(np.floor(bounds.right.max(initial=-1)) + 1, 0, width),
        np.clip(np.floor(bounds.bottom.max(initial=-1)) + 1, 0, height),
    )
    left, top, right, bottom = map(int, ends)
    return Window(left, top, right, bottom)


def joined(one: Window, other: Window) -> Window:
    """The smallest window that holds both."""
    if one.empty or other.empty:
        return other if one.empty else one
    return Window(
        min(one.left, other.left),
        min(one.top, other.top),
        max(one.right, other.right),
        max(one.bottom, other.bottom),
    )
