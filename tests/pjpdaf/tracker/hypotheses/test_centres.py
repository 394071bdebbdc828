"""Centres: palms are outside the skin of whole hands; heads differ by hair, breadth and height."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pjpdaf.arrays import Floats
from pjpdaf.interfaces import Detections
from pjpdaf.looks import BlobLooks, Silhouette
from pjpdaf.tracker.hypotheses.blobs import Blobs
from pjpdaf.tracker.hypotheses.candidates import BESIDE, END, HALF, OTHER_HALF, WHOLE
from pjpdaf.tracker.hypotheses.centres import BESIDE_M, CROWN_M, head_offset, outward
from pjpdaf.tracker.hypotheses.parameters import OffsetParameters

P = OffsetParameters()
# A camera that looks along the world's -y, with z up: its right is -x.
AXES = np.array([[-1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, -1.0, 0.0]])


def test_palms_are_outside_the_skin_of_whole_hands_and_of_bare_arms_ends():
    parts = np.array([[WHOLE, WHOLE], [END, END], [-1, WHOLE], [HALF, OTHER_HALF], [WHOLE, BESIDE]])
    nothing = Detections.none()
    silhouette = Silhouette(np.zeros((4, 4), np.uint8), 2)
    looks = BlobLooks((), 4.0, np.zeros((0, 2)), np.zeros((0, 2)), silhouette)
    shown, points = Blobs.of(replace(nothing, looks=looks)), Blobs.of(nothing)
    right, left = outward(parts, (shown, shown), AXES, P)
    # The person faces the camera: the right hand is on the picture's left, towards the world's +x.
    np.testing.assert_allclose(right[:3], [[P.outward_m, 0.0, 0.0]] * 3)
    np.testing.assert_allclose(right[3:], 0.0)
    np.testing.assert_allclose(left, -right)
    np.testing.assert_array_equal(outward(parts, (points, points), AXES, P), 0.0)


def offset(breadth_m: float, height_m: float, crown_m: float, beside_m: float) -> Floats:
    shape = np.diag([breadth_m / 2, height_m / 2]) ** 2
    return head_offset(AXES, shape, crown_m, beside_m, P) @ AXES.T


# Rendered heads (seeds 73000-73007): breadth, height, crown and beside as tracked; the true vector
# down and away from the centre of the skin.
@pytest.mark.parametrize(
    ("breadth", "height", "crown", "beside", "down", "away"),
    [
        pytest.param(70.8, 90.7, 145.2, 7.1, -29.3, 4.3, id="short hair"),
        pytest.param(66.4, 87.5, 140.9, 35.3, -28.8, 17.4, id="long hair"),
        pytest.param(71.0, 117.7, 116.1, 7.0, -3.9, 0.9, id="bald"),
        pytest.param(72.2, 63.5, 125.7, 19.1, -7.8, 11.5, id="beard"),
    ],
)
def test_centre_of_rendered_heads(
    breadth: float, height: float, crown: float, beside: float, down: float, away: float
):
    found = 1e3 * offset(*(1e-3 * length for length in (breadth, height, crown, beside)))
    np.testing.assert_allclose(found, [0.0, down, away], atol=6.0)  # mm


def test_each_length_has_a_share_that_removes_it():
    none = replace(P, crown_share=0.0, breadth_share=0.0, beside_share=0.0, height_share=0.0)
    for share, crown, beside, shape in (
        ("crown_share", CROWN_M + 0.02, BESIDE_M, np.eye(2)),
        ("beside_share", CROWN_M, BESIDE_M + 0.02, np.eye(2)),
        ("breadth_share", CROWN_M, BESIDE_M, np.diag([1e-3, 2e-3])),
        ("height_share", CROWN_M, BESIDE_M, np.diag([1e-3, 1e-3])),
    ):
        only = replace(none, **{share: getattr(P, share)})
        with_it = head_offset(AXES, shape, crown, beside, only)
        without = head_offset(AXES, shape, crown, beside, none)
        assert np.linalg.norm(with_it - without) > 1e-3, share
        np.testing.assert_allclose(AXES @ without, P.head_offset_m)


def test_without_silhouettes_all_heads_are_alike():
    np.testing.assert_allclose(AXES @ head_offset(AXES, np.eye(2), 0.2, None, P), P.head_offset_m)
