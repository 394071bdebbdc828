"""Detections and associations given by the truth of a frame."""

from dataclasses import replace

import numpy as np
from point_episodes import CAMERAS, HEAD, all_seen, apart, merging, truth_of
from strategies import FOCAL_PX

from pjpdaf.camera import project
from pjpdaf.looks import BlobLooks, Silhouette
from scenarios.play.true_detections import LEAST_VISIBLE_PX, known_targets, true_detections


def test_true_detections_are_at_the_visible_centroids_of_what_shows():
    truth = truth_of(0, apart)
    hidden = replace(truth.views[0], visible_px=np.array([4000, 1500, LEAST_VISIBLE_PX - 1]))
    truth = replace(truth, views=(hidden, truth.views[1]))
    found = true_detections(truth, all_seen(0, truth), CAMERAS)
    assert [len(view) for view in found] == [2, 3]
    np.testing.assert_allclose(found[0].centres_px, project(CAMERAS[0], truth.centres_m[:2]))
    np.testing.assert_allclose(found[1].centres_px, project(CAMERAS[1], truth.centres_m))
    np.testing.assert_array_equal(found[1].areas_px, [4000, 1500, 1500])


def test_true_detections_have_the_real_silhouette_and_the_fingers_of_the_blob_that_shows_them():
    truth = truth_of(0, apart)
    silhouette = Silhouette(np.ones((12, 16), np.uint8), 40)
    fingers = np.array([[0.0, 0.0], [0.1, 0.2], [0.3, 0.4]])
    real = []
    for view in all_seen(0, truth):
        shows = np.linalg.norm(
            view.centres_px[:, None] - truth.views[len(real)].centroids_px[None], axis=2
        ).argmin(axis=1)
        looks = BlobLooks((np.zeros((9, 2)),) * 3, 4.0, fingers[shows], fingers[shows], silhouette)
        real.append(replace(view, looks=looks))
    for view in true_detections(truth, tuple(real), CAMERAS):
        assert view.looks.silhouette is silhouette
        np.testing.assert_array_equal(view.looks.fingers, fingers)
        for pixels, centre in zip(view.looks.pixels, view.centres_px, strict=True):
            np.testing.assert_allclose(pixels.mean(axis=0), centre, atol=0.1)
        covered = view.looks.pixel_area_px * len(view.looks.pixels[1])
        np.testing.assert_allclose(covered, view.areas_px[1], rtol=0.01)


def test_each_target_is_known_to_be_shown_by_its_own_detection_whatever_their_order():
    truth = truth_of(0, apart)
    seen = all_seen(0, truth)
    assigned = known_targets(truth, seen, CAMERAS).pixels(seen)
    for n, camera in enumerate(CAMERAS):
        wanted = project(camera, truth.centres_m)
        assert np.linalg.norm(assigned[n] - wanted, axis=1).max() < 2


def test_a_merged_blob_belongs_to_neither_hand():
    truth = truth_of(0, lambda t: np.array([HEAD, [0.3, -0.052, 0.85], [0.3, 0.052, 0.85]]))
    seen = merging(0, truth)
    assert [len(view) for view in seen] == [2, 2]
    gap_px = 0.104 * FOCAL_PX  # at 1 m
    assert gap_px / 2 > 25
    assigned = known_targets(truth, seen, CAMERAS).pixels(seen)
    assert np.isnan(assigned[:, 1:]).all()
    assert np.isfinite(assigned[:, 0]).all()
