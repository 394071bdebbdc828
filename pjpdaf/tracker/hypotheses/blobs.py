"""Blobs of a view, as the tracker takes them from any detector."""

from __future__ import annotations

from dataclasses import dataclass

from pjpdaf.arrays import Floats
from pjpdaf.interfaces import Detections
from pjpdaf.looks import BlobLooks, looks_of_ellipses


@dataclass(frozen=True, eq=False)
class Blobs:
    """Detections of one view with their looks, of the ellipses where the detector gives none.

    centres_px (n, 2); areas_px (n,); ellipses (n, 5); evidence (n, T) or None; missing: no picture.
    """

    centres_px: Floats
    areas_px: Floats
    ellipses: Floats
    looks: BlobLooks
    evidence: Floats | None
    missing: bool

    @staticmethod
    def of(view: Detections) -> Blobs:
        """Take what the tracker uses of a view's detections."""
        looks = view.looks if view.looks is not None else looks_of_ellipses(view.ellipses)
        return Blobs(
            view.centres_px, view.areas_px, view.ellipses, looks, view.evidence, view.missing
        )

    def __len__(self) -> int:
        return len(self.centres_px)

    def length_m(self, blob: int, metre_px: float) -> float:
        """Length of a blob's ellipse [m] where a metre has this many pixels."""
        return 2.0 * float(self.ellipses[blob, 2]) / metre_px
