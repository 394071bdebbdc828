"""Tracking an episode again with truth in place of a stage."""

from dataclasses import replace

import numpy as np
import pytest
from point_episodes import (
    CAMERAS,
    HEAD,
    Frozen,
    all_seen,
    apart,
    crossing,
    episode_of,
    merging,
    tracker_of,
    truth_of,
)
from strategies import FOCAL_PX

from pjpdaf.camera import project
from pjpdaf.interfaces import Detections
from scenarios.play.oracle import (
    LEAST_VISIBLE_PX,
    Oracle,
    stages_of,
    state_on_truth,
    track_again,
    true_assignment,
    true_detections,
)


def positions(episode):
    return np.stack([outcome.estimates.positions_m for outcome in episode.frames])


def centres(episode):
    return np.stack([outcome.truth.centres_m for outcome in episode.frames])


@pytest.mark.parametrize("motion", [apart, crossing])
def test_without_a_replaced_stage_the_estimates_are_the_same_to_the_last_bit(motion):
    episode = episode_of(motion, merging)
    again = track_again(episode, CAMERAS, tracker_of(), Oracle())
    np.testing.assert_array_equal(positions(again), positions(episode))
    assert [o.estimates.status for o in again.frames] == [
        o.estimates.status for o in episode.frames
    ]


@pytest.mark.parametrize("stage", ["detections", "association"])
def test_with_truth_in_a_stage_the_error_of_a_crossing_is_no_larger(stage):
    episode = episode_of(crossing, merging)
    again = track_again(episode, CAMERAS, tracker_of(), Oracle(**{stage: True}))
    before, after = (
        np.nanmedian(np.linalg.norm(positions(e) - centres(e), axis=-1)) for e in (episode, again)
    )
    assert after <= before + 1e-3  # pixel noise of 0.3 px


def test_true_detections_are_at_the_visible_centroids_of_what_shows():
    truth = truth_of(0, apart)
    hidden = replace(truth.views[0], visible_px=np.array([4000, 1500, LEAST_VISIBLE_PX - 1]))
    truth = replace(truth, views=(hidden, truth.views[1]))
    found = true_detections(truth, all_seen(0, truth), CAMERAS)
    assert [len(view) for view in found] == [2, 3]
    np.testing.assert_allclose(found[0].centres_px, project(CAMERAS[0], truth.centres_m[:2]))
    np.testing.assert_allclose(found[1].centres_px, project(CAMERAS[1], truth.centres_m))
    np.testing.assert_array_equal(found[1].areas_px, [4000, 1500, 1500])


def test_the_state_on_truth_has_its_position_and_velocity_and_the_same_covariance():
    tracker = tracker_of()
    state = tracker.start(all_seen(0, truth_of(0, apart)))
    assert state is not None
    truth = truth_of(12, crossing)
    moved = state_on_truth(state, truth)
    np.testing.assert_array_equal(moved.mean[:, :3], truth.centres_m)
    np.testing.assert_array_equal(moved.mean[:, 3:], truth.velocities_mps)
    np.testing.assert_array_equal(moved.covariance, state.covariance)


def test_true_assignment_gives_each_target_its_own_detection_whatever_their_order():
    truth = truth_of(0, apart)
    seen = all_seen(0, truth)
    assigned = true_assignment(truth, seen, CAMERAS)
    for n, camera in enumerate(CAMERAS):
        wanted = project(camera, truth.centres_m)
        assert np.linalg.norm(assigned[n] - wanted, axis=1).max() < 2


def test_a_merged_blob_belongs_to_neither_hand():
    truth = truth_of(0, lambda t: np.array([HEAD, [0.3, -0.052, 0.85], [0.3, 0.052, 0.85]]))
    seen = merging(0, truth)
    assert [len(view) for view in seen] == [2, 2]
    gap_px = 0.104 * FOCAL_PX  # at 1 m
    assert gap_px / 2 > 25
    assigned = true_assignment(truth, seen, CAMERAS)
    assert np.isnan(assigned[:, 1:]).all()
    assert np.isfinite(assigned[:, 0]).all()


def test_a_missing_picture_stays_missing():
    def one_eyed(index, truth):
        seen = all_seen(index, truth)
        return (seen[0], Detections.none(missing=True)) if index > 5 else seen

    episode = episode_of(apart, one_eyed, frames=12)
    again = track_again(episode, CAMERAS, tracker_of(), Oracle(detections=True))
    assert [o.detections[1].missing for o in again.frames] == [i > 5 for i in range(12)]


def test_of_a_plug_in_only_the_detections_can_be_replaced():
    assert stages_of(Frozen()) == ("detections",)
    episode = episode_of(apart, all_seen, frames=8)
    with pytest.raises(ValueError, match="PJPDAF only"):
        track_again(episode, CAMERAS, Frozen(), Oracle(association=True))
