"""One view of a frame beside the other, with the rays of both."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sim.dataset.check.frame.arrays import FrameArrays, ViewArrays, present
from sim.dataset.check.frame.pixel_rays import PixelRays, RigRays
from sim.dataset.files.layout import DEPTH_UNIT_M
from sim.dataset.labels.instances import ROOM, TABLE

STATIC = (TABLE, ROOM)  # in the same place at both moments of a rig with shutter skew
FEW = 50  # pixels, of which no share is taken


@dataclass(frozen=True, eq=False)
class FrameView:
    """A view (0 left, 1 right) of a frame, for checks that compare it with the other view."""

    frame: FrameArrays
    view: int
    rig: RigRays

    @property
    def own(self) -> ViewArrays:
        """Arrays of this view."""
        return self.frame.views[self.view]

    @property
    def other(self) -> ViewArrays:
        """Arrays of the other view."""
        return self.frame.views[1 - self.view]

    @property
    def rays(self) -> PixelRays:
        """Rays of this view."""
        return self.rig.views[self.view]

    @property
    def other_rays(self) -> PixelRays:
        """Rays of the other view."""
        return self.rig.views[1 - self.view]

    @property
    def is_late(self) -> bool:
        """Whether this view is of a later moment than the labels of the pair (shutter skew)."""
        return self.rig.is_late(self.view)

    def file(self, label: str) -> str:
        """Path of this view's file of a label, from the data set's folder."""
        return self.frame.file(label, self.view)

    def other_file(self, label: str) -> str:
        """Path of the other view's file of a label, from the data set's folder."""
        return self.frame.file(label, 1 - self.view)


def is_static(ids: NDArray[np.generic]) -> NDArray[np.bool_]:
    """Which instance ids are of table and room, which never move."""
    return np.isin(ids, STATIC)


def still_pixels(own: ViewArrays, other: ViewArrays) -> NDArray[np.bool_]:
    """Pixels (h, w) at which two frames of a view show the same spot of table or room.

    By their ids, and their depth where both have it.
    """
    seg = present(own.seg)
    still = is_static(seg) & (seg == present(other.seg))
    if own.depth_m is not None and other.depth_m is not None:
        still &= np.abs(own.depth_m - other.depth_m) <= DEPTH_UNIT_M / 2
    return np.asarray(still)
