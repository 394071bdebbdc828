import json

import numpy as np
import pytest

from pjpdaf.errors import BenchError
from pjpdaf.targets import LEFT_HAND, RIGHT_HAND
from scenarios.play.fast import play_fast
from scenarios.play.fast_trust import FILE, FastTrust, trusted
from scenarios.play.job import Job, System
from scenarios.spec.draw import fault_of_draw, judged, perform, unjudged
from scenarios.spec.names import load_scenario, scenario_names
from scenarios.stress.families import FAMILIES

FRAMES = {"frames": 24.0}


def job(name="cross", seed=8001, preset="thesis", **changes):
    return Job(load_scenario(name), seed, {**FRAMES, **changes}, System(preset, preset))


def positions(episode):
    return np.stack([outcome.estimates.positions_m for outcome in episode.frames])


@pytest.mark.parametrize("preset", ["thesis", "default"])
def test_a_fast_episode_is_tracked_and_the_same_twice(preset):
    one, other = (play_fast(job(preset=preset)) for _ in range(2))
    np.testing.assert_array_equal(positions(one), positions(other))
    truths = np.stack([outcome.truth.centres_m for outcome in one.frames])
    errors = np.linalg.norm(positions(one) - truths, axis=2)
    # The hands rise apart from each other for the first frames.
    assert np.nanmedian(errors[:8], axis=0).max() < 0.06
    merged = [o.truth.views[0].merged[RIGHT_HAND, LEFT_HAND] for o in one.frames]
    blobs = np.array([len(outcome.detections[0]) for outcome in one.frames])
    assert any(merged)
    assert (blobs[~np.array(merged)] == 3).mean() > 0.9


def test_the_motion_is_that_of_the_rendered_episode():
    episode = play_fast(job("drink", 3))
    performance = perform(load_scenario("drink"), 3, FRAMES)
    for outcome in episode.frames[::5]:
        pose = performance.script.pose(outcome.truth.time_s)
        expected = [pose.head.position_m, *(hand.position_m for hand in pose.hands)]
        np.testing.assert_allclose(outcome.truth.centres_m, expected, atol=1e-9)
        assert outcome.truth.script_events == performance.script.events(outcome.truth.time_s)


def test_lost_pictures_skew_and_lens_are_played():
    changes = {"dropped": 10, "shutter_skew": 30, "lens_k1": -0.1, "calibration_rot_y": 0.5}
    for preset in ("thesis", "default"):
        episode = play_fast(job("natural_table", 1, preset, **changes))
        missing = [view.missing for outcome in episode.frames for view in outcome.detections]
        assert 0.02 < np.mean(missing) < 0.3


def test_a_lag_looks_back():
    at_once, later = (
        play_fast(Job(load_scenario("cross"), 8001, FRAMES, System(lag=lag))) for lag in (0, 3)
    )
    assert len(later.frames) == len(at_once.frames)
    last = -1
    np.testing.assert_array_equal(positions(later)[last], positions(at_once)[last])


def test_a_detector_of_ones_own_has_no_stand_in():
    other = System("json:JSONDecoder", "thesis")
    with pytest.raises(BenchError, match="stand-in for the detectors of presets only"):
        play_fast(Job(load_scenario("cross"), 1, FRAMES, other))


def test_draws_are_judged_afterwards():
    scenario = load_scenario("cross")
    too_far = {
        **{"spread": 0.28, "past": 0.2, "centre_x": 0.42, "height": 0.32},
        **{"stature": 1.52, "arm_scale": 0.95},
    }
    rejected = unjudged(scenario, 0, too_far)
    assert "goes across the body" in judged(rejected)
    assert "goes across the body" in fault_of_draw(scenario, 0, too_far)
    assert judged(unjudged(scenario, 0)) is None
    assert fault_of_draw(scenario, 0) is None


def test_trust_is_that_of_enough_episodes_that_agree():
    assert FastTrust(episodes=8, both=2, only_full=1, only_fast=0).trusted
    assert not FastTrust(episodes=8, both=2, only_full=1, only_fast=1).trusted
    assert not FastTrust(episodes=5, both=0, only_full=0, only_fast=0).trusted
    assert trusted("nobody's", "cross") is None
    systems = json.loads(FILE.read_text(encoding="utf-8"))["systems"]
    assert set(systems) == {"thesis", "default"}
    known = {*scenario_names(), *FAMILIES}
    assert all(set(found) <= known for found in systems.values())
