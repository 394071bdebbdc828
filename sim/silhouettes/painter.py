"""Paints the frames of a film, each once although detector and truth both ask for it."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pjpdaf.interfaces import Detections
from sim.silhouettes.film import Film
from sim.silhouettes.outlines import Outlines, paint
from sim.silhouettes.patches import Box, Patches, patch_of


class PaintedView(NamedTuple):
    """A view of a frame: classes uint8 (h, w) of `sim.silhouettes.shapes`, of the picture reduced
    by step_px, without the lens's distortion; patches: of the targets; skin_box: around all skin,
    as in `sim.silhouettes.outlines`.
    """

    classes: NDArray[np.uint8]
    step_px: int
    patches: Patches
    skin_box: Box


class Painter:
    """Paints frames of a film; the last `kept` frames are not painted twice."""

    def __init__(self, film: Film, kept: int = 1) -> None:
        self.film = film
        self._kept = kept
        self._painted: dict[int, tuple[PaintedView, ...]] = {}

    def paint(self, frame: int) -> tuple[PaintedView, ...]:
        """The views of a frame; not to be written to."""
        if frame not in self._painted:
            while len(self._painted) >= self._kept:
                self._painted.pop(next(iter(self._painted)))
            self._painted[frame] = tuple(
                _painted(outlines, frame) for outlines in self.film.outlines
            )
        return self._painted[frame]

    def detected(
        self, frame: int, detect: Callable[[int, PaintedView], Detections]
    ) -> tuple[Detections, ...]:
        """The detections of each view of a frame; `missing` where its picture did not arrive.

        detect: gives those of a view by its number.
        """
        arrived = self.film.moments[frame].arrived
        return tuple(
            detect(number, view) if arrived[number] else Detections.none(missing=True)
            for number, view in enumerate(self.paint(frame))
        )


def _painted(outlines: Outlines, frame: int) -> PaintedView:
    canvas = np.zeros(outlines.size, np.uint8)
    paint(outlines, frame, canvas)
    boxes = zip(outlines.target_boxes[frame], outlines.covered[frame], strict=True)
    patches = (patch_of(canvas, t, box, covered) for t, (box, covered) in enumerate(boxes))
    return PaintedView(canvas, outlines.step_px, tuple(patches), outlines.skin_boxes[frame])
