"""Tracking an episode again with truth in place of a stage."""

from dataclasses import replace

import numpy as np
import pytest
from point_episodes import (
    CAMERAS,
    FPS,
    Frozen,
    all_seen,
    apart,
    crossing,
    episode_of,
    merging,
    tracker_of,
    truth_of,
)

from pjpdaf.camera import triangulate
from pjpdaf.interfaces import Detections, Estimates
from pjpdaf.known_targets import KnownTargets
from pjpdaf.plugins.checked import CheckedTracker
from reports.score.events import swap_margin
from scenarios.play.oracle import (
    Oracle,
    stages_of,
    track_again,
)


def positions(episode):
    return np.stack([outcome.estimates.positions_m for outcome in episode.frames])


def centres(episode):
    return np.stack([outcome.truth.centres_m for outcome in episode.frames])


def margin(episode):
    return swap_margin(centres(episode), positions(episode))


@pytest.mark.parametrize("preset", ["thesis", "default"])
@pytest.mark.parametrize("motion", [apart, crossing])
def test_without_a_replaced_stage_the_estimates_are_the_same_to_the_last_bit(motion, preset):
    episode = episode_of(motion, merging, tracker=tracker_of(preset))
    again = track_again(episode, CAMERAS, tracker_of(preset), Oracle())
    np.testing.assert_array_equal(positions(again), positions(episode))
    assert [o.estimates.status for o in again.frames] == [
        o.estimates.status for o in episode.frames
    ]


@pytest.mark.parametrize("preset", ["thesis", "default"])
@pytest.mark.parametrize("stage", ["detections", "association"])
def test_with_truth_in_a_stage_the_error_of_a_crossing_is_no_larger(stage, preset):
    episode = episode_of(crossing, merging, tracker=tracker_of(preset))
    again = track_again(episode, CAMERAS, tracker_of(preset), Oracle(**{stage: True}))
    before, after = (
        np.nanmedian(np.linalg.norm(positions(e) - centres(e), axis=-1)) for e in (episode, again)
    )
    assert after <= before + 1e-3  # pixel noise of 0.3 px


def test_a_missing_picture_stays_missing():
    def one_eyed(index, truth):
        seen = all_seen(index, truth)
        return (seen[0], Detections.none(missing=True)) if index > 5 else seen

    episode = episode_of(apart, one_eyed, frames=12)
    again = track_again(episode, CAMERAS, tracker_of(), Oracle(detections=True))
    assert [o.detections[1].missing for o in again.frames] == [i > 5 for i in range(12)]


def test_hands_that_default_exchanges_keep_their_names_where_association_is_known():
    """No sleeve is seen, so that a crossing with one merged blob is decided by motion alone."""
    tracker = tracker_of("default")
    episode = episode_of(crossing, merging, tracker=tracker)
    assert margin(episode)[-1] < 0
    again = track_again(episode, CAMERAS, tracker, Oracle(association=True))
    assert margin(again)[-1] > 0.9


@pytest.mark.parametrize("preset", ["thesis", "default"])
def test_where_the_process_is_known_the_prediction_is_the_truth(preset):
    tracker = tracker_of(preset)
    state = tracker.start(all_seen(0, truth_of(0, apart)))
    truth = truth_of(15, crossing)
    known = KnownTargets(truth.centres_m, truth.velocities_mps, np.full((2, 3), -1))
    moved = tracker.expecting(state, known, 1 / FPS)
    predicted = tracker.predict(moved, 1 / FPS)
    seen = all_seen(15, truth)
    _, plain = tracker.step(state, seen, 1 / FPS)
    _, aided = tracker.step(moved, seen, 1 / FPS)
    if preset == "thesis":  # the prediction of default is what it said last
        np.testing.assert_allclose(predicted.positions_m, truth.centres_m, atol=1e-12)
    off = [np.linalg.norm(e.positions_m - truth.centres_m, axis=1).max() for e in (plain, aided)]
    assert off[1] < 0.05 < 0.15 < off[0]


def test_of_a_plug_in_only_the_detections_can_be_replaced():
    assert stages_of(Frozen()) == ("detections",)
    assert stages_of(CheckedTracker("mine", Frozen())) == ("detections",)
    episode = episode_of(apart, all_seen, frames=8)
    with pytest.raises(ValueError, match="does not let its association be replaced"):
        track_again(episode, CAMERAS, Frozen(), Oracle(association=True))


class Nearest(Frozen):
    """A plug-in whose association can be replaced: it triangulates what it is given."""

    def step_associated(self, state, seen, known, dt_s):
        pixels = known.pixels(seen)
        places = [triangulate(CAMERAS, pixels[:, t]) for t in range(3)]
        return state, replace(Estimates.waiting(), positions_m=np.array(places))


def test_a_plug_in_with_the_method_has_its_association_replaced():
    tracker = CheckedTracker("mine", Nearest())
    assert stages_of(tracker) == ("detections", "association")
    episode = episode_of(apart, all_seen, frames=8)
    again = track_again(episode, CAMERAS, tracker, Oracle(association=True))
    np.testing.assert_allclose(positions(again)[1:], centres(again)[1:], atol=0.03)
