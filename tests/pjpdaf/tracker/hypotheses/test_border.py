"""A ball that the picture's edge cuts keeps its depth and its centre."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pjpdaf.interfaces import Detections
from pjpdaf.tracker.hypotheses.blobs import Blobs
from pjpdaf.tracker.hypotheses.border import WIDTH_PX, agreed_centres, cut_sides
from pjpdaf.tracker.hypotheses.geometry import Views
from tests.pjpdaf.tracker.hypotheses.test_split import disc
from tests.strategies import rig

VIEWS = Views.of(rig().cameras)
WIDTH = WIDTH_PX * VIEWS.scale


def blob_at(centre_px: np.ndarray) -> Blobs:
    """What a picture shows of a ball of 24 px."""
    pixels = disc(0.0, 0.0, 24.0) + centre_px
    pixels = pixels[(pixels[:, 0] >= 0) & (pixels[:, 0] <= WIDTH - 1)]
    blobs = Blobs.of(
        Detections(
            pixels.mean(axis=0)[None],
            np.eye(2)[None],
            np.array([[*pixels.mean(axis=0), 24.0, 24.0, 0.0]]),
            np.array([9.0 * len(pixels)]),
        )
    )
    return replace(blobs, looks=replace(blobs.looks, pixels=(pixels,), pixel_area_px=9.0))


def seen_at(left_x: float) -> tuple[np.ndarray, tuple[Blobs, Blobs]]:
    """A point (3,) 1 m away that the left view has at column left_x, and the views' blobs."""
    ray = VIEWS.rays(0, np.array([[left_x, 200.0]]))[0]
    point = VIEWS.centres_m[0] + ray
    pixels, _ = VIEWS.project(point)
    return point, (blob_at(pixels[0]), blob_at(pixels[1]))


@pytest.mark.parametrize("beyond", [-10.0, 0.0, 10.0])
def test_depth_and_centre_of_a_ball_cut_in_one_view(beyond):
    point, seen = seen_at(WIDTH - 12.0 + beyond)
    assert cut_sides(seen[0], VIEWS).tolist() == [1]
    assert cut_sides(seen[1], VIEWS).tolist() == [0]
    centroids = VIEWS.triangulate(seen[0].centres_px, seen[1].centres_px)[0][0]
    centres = agreed_centres(VIEWS, seen, (0, 0), 1)
    assert centres is not None
    agreed = VIEWS.triangulate(centres[0][None], centres[1][None])[0][0]
    error, before = np.linalg.norm(agreed - point), np.linalg.norm(centroids - point)
    assert error < 0.025
    assert before > 3 * error


def test_ball_inside_the_picture_is_not_cut():
    _, seen = seen_at(WIDTH / 2)
    assert cut_sides(seen[0], VIEWS).tolist() == [0]


def test_too_few_common_rows_give_no_centres():
    _, (left, right) = seen_at(WIDTH - 12.0)
    thin = right.looks.pixels[0][:3]
    assert agreed_centres(VIEWS, (left, replace_pixels(right, thin)), (0, 0), 1) is None


def replace_pixels(blobs: Blobs, pixels: np.ndarray) -> Blobs:
    return replace(blobs, looks=replace(blobs.looks, pixels=(pixels,)))
