"""Hair beside the face: the width of the person beside the face's skin, at most so much a side."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pjpdaf.interfaces import Detections
from pjpdaf.looks import CLOTHED, SKIN, BlobLooks, Silhouette
from pjpdaf.tracker.hypotheses.blobs import Blobs
from pjpdaf.tracker.hypotheses.geometry import Views
from pjpdaf.tracker.hypotheses.hair_beside import hair_beside
from tests.strategies import rig

VIEWS = Views.of(rig().cameras)
HEAD_M = np.array([0.0, 0.0, 1.2])
STEP_PX = 2


def views_of(hair_m: float, hidden: bool = False) -> tuple[Blobs, ...]:
    """Both views of a face 0.14 m wide with so much hair on either side; hidden: hair all over."""
    pixels, depth = VIEWS.project(HEAD_M)
    seen = []
    for view in range(2):
        metre = VIEWS.focal_px[view] / depth[view] / STEP_PX
        u, v = (pixels[view] + 0.5) / STEP_PX
        rows, columns = np.indices((240, 320))
        across, down = np.abs(columns - u) / metre, np.abs(rows - v) / metre
        classes = np.where((across < 0.07 + hair_m) & (down < 0.1), CLOTHED, 0)
        if not hidden:
            classes[(across < 0.07) & (down < 0.1)] = SKIN
        none = np.zeros((0, 2))
        looks = BlobLooks((), 4.0, none, none, Silhouette(classes.astype(np.uint8), STEP_PX))
        seen.append(Blobs.of(replace(Detections.none(), looks=looks)))
    return tuple(seen)


@pytest.mark.parametrize(("hair_m", "beside_m"), [(0.0, 0.0), (0.02, 0.04), (0.3, 0.12)])
def test_width_of_both_sides(hair_m: float, beside_m: float):
    found = hair_beside(HEAD_M, views_of(hair_m), VIEWS)
    assert found == pytest.approx(beside_m, abs=0.008)  # a pixel of the reduced picture is 4 mm


def test_without_skin_at_the_heads_centre_or_silhouettes_nothing_is_known():
    assert hair_beside(HEAD_M, views_of(0.02, hidden=True), VIEWS) is None
    nothing = Blobs.of(Detections.none())
    assert hair_beside(HEAD_M, (nothing, nothing), VIEWS) is None
    assert hair_beside(HEAD_M + np.array([9.0, 0.0, 0.0]), views_of(0.02), VIEWS) is None
