"""Paints the frames of a film, each once although detector and truth both ask for it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sim.silhouettes.film import Film
from sim.silhouettes.outlines import paint
from sim.silhouettes.patches import Patches, patch_of


class PaintedView(NamedTuple):
    """A view of a frame: classes uint8 (h, w) of `sim.silhouettes.shapes`, of the picture reduced
    by step_px, without the lens's distortion; patches: of the targets.
    """

    classes: NDArray[np.uint8]
    step_px: int
    patches: Patches


class Painter:
    """Paints frames of a film; the last one is kept."""

    def __init__(self, film: Film) -> None:
        self.film = film
        self._last: tuple[int, tuple[PaintedView, ...]] = (-1, ())

    def paint(self, frame: int) -> tuple[PaintedView, ...]:
        """The views of a frame; not to be written to."""
        if self._last[0] != frame:
            views = []
            for outlines in self.film.outlines:
                canvas = np.zeros(outlines.size, np.uint8)
                paint(outlines, frame, canvas)
                patches = tuple(
                    patch_of(canvas, target, box, covered)
                    for target, (box, covered) in enumerate(
                        zip(outlines.target_boxes[frame], outlines.covered[frame], strict=True)
                    )
                )
                views.append(PaintedView(canvas, outlines.step_px, patches))
            self._last = frame, tuple(views)
        return self._last[1]
