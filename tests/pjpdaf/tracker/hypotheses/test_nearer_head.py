"""A larger blob of the head: nearer, or with something in it."""

import numpy as np
import pytest
from strategies import rig

from pjpdaf.camera import project
from pjpdaf.tracker.hypotheses.candidates import HeadPlace
from pjpdaf.tracker.hypotheses.geometry import Views
from pjpdaf.tracker.hypotheses.nearer_head import free_axes, nearer_head

VIEWS = Views.of(rig().cameras)
HALF_AXES_M = 0.06, 0.09
AREA_M2 = np.pi * HALF_AXES_M[0] * HALF_AXES_M[1]
SHAPE_M2 = np.diag([HALF_AXES_M[0] ** 2, HALF_AXES_M[1] ** 2]) / 4


class Shown:
    """What the part reads of a view's blobs: one ellipse, the head's, wider by a factor."""

    def __init__(self, view, head_m, wider):
        scale = VIEWS.focal_px[view] / VIEWS.project(head_m)[1][view]
        a, b = HALF_AXES_M[0] * scale * wider, HALF_AXES_M[1] * scale
        self.centres_px = project(rig().cameras[view], head_m[None])
        self.areas_px = np.array([np.pi * a * b])
        self.ellipses = np.array([[*self.centres_px[0], b, a, 0.0]])


def places_of(away_m, wider=1.0, free=False, shift_px=0.0):
    head_m = np.array([0.05, -0.05, away_m])
    seen = tuple(Shown(view, head_m, wider) for view in (0, 1))
    seen[1].centres_px = seen[1].centres_px + np.array([0.0, shift_px])
    # Where an ellipse came to rest in each blob: a little beside its centroid.
    before = tuple(HeadPlace(0, free, v.centres_px[0] + 3.0, np.eye(2)) for v in seen)
    after = nearer_head(before, seen, VIEWS, AREA_M2, SHAPE_M2, 1.1, 6.0)
    return before, after, seen


@pytest.mark.parametrize("away_m", [0.9, 1.2, 1.5])
def test_a_head_of_its_size_in_metres_is_free_at_any_distance(away_m):
    _, after, seen = places_of(away_m)
    for place, view in zip(after, seen, strict=True):
        assert place.free
        np.testing.assert_array_equal(place.centre_px, view.centres_px[0])


@pytest.mark.parametrize("how", [{"wider": 1.3}, {"shift_px": 40.0}, {"free": True}])
def test_what_has_something_in_it_or_differs_between_the_views_stays(how):
    before, after, _ = places_of(1.2, **how)
    assert after == before


def test_the_axes_of_a_shape_are_those_of_its_ellipse():
    turned = np.array([[0.8, -0.6], [0.6, 0.8]])
    np.testing.assert_allclose(free_axes(turned @ SHAPE_M2 @ turned.T), HALF_AXES_M)
