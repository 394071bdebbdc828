"""An episode played for real, in small pictures: the bare episode, and what is added to it."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from reports.score.records import BUDGET_LEVELS
from scenarios.play.blame import blame
from scenarios.play.error_budget import error_budget
from scenarios.play.footage import open_footage
from scenarios.play.job import Job, System, digest_of
from scenarios.play.pictures import MAX_PICTURES
from scenarios.play.play import make_system, play, play_complete, play_footage
from scenarios.spec.names import load_scenario

JOB = Job(
    load_scenario("cross"),
    101,
    {"frames": 6, "background_frames": 10},
    System(),
    keep_pictures=True,
    keep_film=True,
    size_px=(160, 120),
)


@pytest.fixture(scope="module")
def bare():
    return play(JOB)


@pytest.fixture(scope="module")
def complete():
    return play_complete(JOB)


def test_the_bare_episode_has_frames_alone(bare):
    assert len(bare.frames) == 6
    assert [outcome.truth.index for outcome in bare.frames] == list(range(6))
    assert bare.digest == digest_of(JOB)
    assert (bare.scenario, bare.seed, bare.fps) == ("cross", 101, JOB.scenario.fps)
    assert (bare.pictures, bare.film, bare.blame, bare.budget_m) == ((), (), {}, {})
    assert bare.frames[0].stage_s.keys() == {"render", "detect", "track"}
    assert all(view.mask is None for outcome in bare.frames for view in outcome.detections)


def test_what_is_added_changes_no_frame(bare, complete):
    for one, other in zip(bare.frames, complete.frames, strict=True):
        np.testing.assert_array_equal(one.estimates.positions_m, other.estimates.positions_m)
        np.testing.assert_array_equal(one.truth.centres_m, other.truth.centres_m)
        for mine, theirs in zip(one.detections, other.detections, strict=True):
            np.testing.assert_array_equal(mine.centres_px, theirs.centres_px)
    assert bare.values == complete.values


def test_blame_and_budget_are_those_of_the_bare_episode_with_its_looks(bare, complete):
    looks = []
    with open_footage(JOB) as footage:
        cameras = footage.calibration.cameras
        system = make_system(JOB.system, footage.calibration)
        play_footage(JOB, footage, *system, lambda step, truth: looks.append(step.detections))
    assert complete.blame == blame(bare, cameras, system[1], looks)
    budget = error_budget(bare, cameras, system[1], looks)
    assert tuple(complete.budget_m) == tuple(budget) == BUDGET_LEVELS
    for level, errors in budget.items():
        np.testing.assert_array_equal(complete.budget_m[level], errors)
    errors = complete.budget_m["association"]
    assert np.isfinite(errors).any()
    positions = np.stack([outcome.estimates.positions_m for outcome in complete.frames])
    centres = np.stack([outcome.truth.centres_m for outcome in complete.frames])
    made = np.isfinite(errors)
    np.testing.assert_allclose(errors[made], np.linalg.norm(positions - centres, axis=2)[made])


def test_pictures_are_of_chosen_frames_and_the_film_of_all(complete):
    assert 0 < len(complete.pictures) <= MAX_PICTURES
    assert [still.frame for still in complete.film] == list(range(6))
    shown = cv2.imdecode(np.frombuffer(complete.pictures[0].jpeg, np.uint8), cv2.IMREAD_COLOR)
    assert shown is not None
    without = play_complete(replace(JOB, keep_pictures=False, keep_film=False))
    assert (without.pictures, without.film) == ((), ())


def test_every_frame_is_handed_over_with_its_own_truth():
    handed = []
    with open_footage(JOB) as footage:
        system = make_system(JOB.system, footage.calibration)
        episode = play_footage(JOB, footage, *system, lambda *pair: handed.append(pair))
    assert [followed.frame.index for followed, _ in handed] == list(range(6))
    for (followed, truth), outcome in zip(handed, episode.frames, strict=True):
        assert followed.frame.time_s == truth.time_s
        assert outcome.truth is truth
        assert outcome.estimates is followed.estimates


def test_a_job_may_have_smaller_pictures(bare):
    assert [(c.width_px, c.height_px) for c in bare.cameras] == [(160, 120)] * 2
    assert digest_of(replace(JOB, size_px=None)) != digest_of(JOB)


@pytest.mark.long
def test_with_a_lag_the_last_frame_is_as_without_and_the_detections_all_are(bare):
    late = play(replace(JOB, system=System(lag=2)))
    assert [o.truth.index for o in late.frames] == [o.truth.index for o in bare.frames]
    for one, other in zip(bare.frames, late.frames, strict=True):
        np.testing.assert_array_equal(one.truth.centres_m, other.truth.centres_m)
        for mine, theirs in zip(one.detections, other.detections, strict=True):
            np.testing.assert_array_equal(mine.centres_px, theirs.centres_px)
    last, again = bare.frames[-1].estimates, late.frames[-1].estimates
    np.testing.assert_array_equal(last.positions_m, again.positions_m)
