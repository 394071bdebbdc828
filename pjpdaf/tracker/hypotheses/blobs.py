"""Blobs of a view, as the tracker takes them from any detector."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.interfaces import Detections
from pjpdaf.looks import BlobLooks, looks_of_ellipses

MOST_BLOBS = 40


@dataclass(frozen=True, eq=False)
class Blobs:
    """Detections of one view with their looks, of the ellipses where the detector gives none.

    At most MOST_BLOBS, the largest, so that a frame's cost is bounded.

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
        kept = np.arange(len(view))
        if len(view) > MOST_BLOBS:
            kept = np.sort(np.argsort(-view.areas_px, kind="stable")[:MOST_BLOBS])
        ellipses = view.ellipses[kept]
        looks = view.looks.of(kept) if view.looks is not None else looks_of_ellipses(ellipses)
        evidence = None if view.evidence is None else view.evidence[kept]
        return Blobs(
            view.centres_px[kept], view.areas_px[kept], ellipses, looks, evidence, view.missing
        )

    def __len__(self) -> int:
        return len(self.centres_px)

    def length_m(self, blob: int, metre_px: float) -> float:
        """Length of a blob's ellipse [m] where a metre has this many pixels."""
        return 2.0 * float(self.ellipses[blob, 2]) / metre_px

    def thickness_m(self, blob: int, metre_px: float) -> float:
        """Thickness of a blob's ellipse [m] where a metre has this many pixels."""
        return 2.0 * float(self.ellipses[blob, 3]) / metre_px
