import dataclasses

import numpy as np
import pytest

from pjpdaf.errors import BenchError
from reports.score.records import Episode
from scenarios.play.job import Job, System
from scenarios.play.play import play, play_complete
from scenarios.spec.cameras import PARAMETERS
from scenarios.spec.draw import perform
from scenarios.spec.names import load_scenario
from scenarios.spec.parameters.distributions import Fixed
from scenarios.spec.parameters.numeric import Numeric
from sim.camera.colour import balance_rgb
from sim.specs import CalibrationError, ClockSpec, SensorSpec

CALM = load_scenario("calm_table")
SEED = 103
SIZE_PX = (320, 240)  # the smallest pictures in which hands are tracked well


def scene(**overrides):
    return perform(CALM, SEED, {"frames": 3, **overrides}).scene


def test_nominally_there_is_read_noise_and_nothing_else():
    plain = scene()
    quiet = SensorSpec(
        noise_sd=plain.sensor.noise_sd, flicker_rad=plain.sensor.flicker_rad
    )  # a phase without flicker
    assert plain.sensor == quiet
    assert plain.clock == ClockSpec()
    assert plain.calibration_error == CalibrationError()
    assert plain.rig.distortion == ()
    assert plain.rig.principal_offset_px == (0.0, 0.0)


@pytest.mark.parametrize(
    ("setting", "part", "field", "expected"),
    [
        ({"exposure_time": "40 ms"}, "sensor", "exposure_time_s", 0.04),
        ({"exposure_time": 20}, "sensor", "exposure_time_s", 0.02),
        ({"shutter_skew": "0.05 s"}, "sensor", "skew_s", 0.05),
        ({"exposure": -1.5}, "sensor", "exposure_ev", -1.5),
        ({"white_balance": "2700 K"}, "sensor", "white_balance_rgb", balance_rgb(2700.0)),
        ({"flicker": "5 %"}, "sensor", "flicker", 0.05),
        ({"flicker_rate": "120 Hz"}, "sensor", "flicker_hz", 120.0),
        ({"noise_sd": 12}, "sensor", "noise_sd", 12.0),
        ({"shot_noise": 12}, "sensor", "shot_noise_sd", 12.0),
        ({"jpeg_quality": 60.4}, "sensor", "jpeg_quality", 60),
        ({"jitter": "50 ms"}, "clock", "jitter_s", 0.05),
        ({"stamps": "nominal"}, "clock", "stamps", "nominal"),
        ({"dropped": "10 %"}, "clock", "dropped", 0.1),
        ({"calibration_baseline": -5}, "calibration_error", "baseline", -0.05),
        ({"calibration_focal": "3 %"}, "calibration_error", "focal", 0.03),
        (
            {"calibration_rot_x": "1 deg", "calibration_rot_z": -0.5},
            "calibration_error",
            "rotation_rad",
            (np.radians(1.0), 0.0, np.radians(-0.5)),
        ),
        ({"lens_k1": -0.2, "lens_k2": 0.1}, "rig", "distortion", (-0.2, 0.1, 0.0, 0.0)),
        ({"principal_x": 30, "principal_y": -20}, "rig", "principal_offset_px", (30.0, -20.0)),
    ],
)
def test_each_parameter_reaches_its_record_and_moves_nothing_else(setting, part, field, expected):
    plain, changed = scene(), scene(**setting)
    found = getattr(getattr(changed, part), field)
    assert found == (expected if isinstance(expected, str) else pytest.approx(expected))
    undone = dataclasses.replace(
        getattr(changed, part), **{field: getattr(getattr(plain, part), field)}
    )
    assert dataclasses.replace(changed, **{part: undone}) == plain


def test_every_range_can_be_played_to_its_ends():
    for name, parameter in PARAMETERS.items():
        if isinstance(parameter, Numeric) and isinstance(parameter.nominal, Fixed):
            for end in parameter.range:
                scene(**{name: end})
    for k1 in (-0.22, 0.15):
        for k2 in (0.0, 0.2):
            scene(lens_k1=k1, lens_k2=k2, focal=490)


def test_a_lens_that_folds_the_picture_is_a_clear_line():
    with pytest.raises(BenchError, match=r"lens_k1, lens_k2: .*take a smaller lens_k1"):
        scene(lens_k1=-0.2, focal=420)


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ({"exposure_time": "50 ms"}, "exposure_time: 50 ms is outside its range 0 to 40 ms"),
        ({"dropped": "20 %"}, "dropped: 20 % is outside its range 0 to 10 %"),
        ({"white_balance": 1000}, "white_balance: 1000 K is outside its range 2700 to 7500 K"),
        ({"stamps": "late"}, "stamps: must be one of actual, nominal, got 'late'"),
        ({"shutter_skew": "1 m"}, "shutter_skew: must be in s, ms, got unit 'm'"),
    ],
)
def test_what_does_not_fit_is_refused(setting, message):
    with pytest.raises(BenchError, match=message):
        scene(**setting)


@pytest.mark.long
def test_an_episode_with_every_effect_is_tracked_to_its_end():
    changes = {
        "frames": 10,
        "exposure_time": 10,
        "shutter_skew": 20,
        "exposure": 0.3,
        "white_balance": 6000,
        "flicker": 2,
        "shot_noise": 2,
        "jpeg_quality": 85,
        "jitter": 50,
        "dropped": 10,
        "lens_k1": -0.15,
        "lens_k2": 0.05,
        "principal_x": 5,
        "calibration_baseline": 2,
        "calibration_rot_y": 0.1,
    }
    episode = play_complete(Job(CALM, SEED, changes, System(), keep_pictures=True, size_px=SIZE_PX))
    assert isinstance(episode, Episode)
    assert len(episode.frames) == 10
    missing = [d.missing for outcome in episode.frames for d in outcome.detections]
    assert any(missing)
    assert not all(missing)
    times = [outcome.truth.time_s for outcome in episode.frames]
    assert times != [index / 3 for index in range(10)]
    assert (np.diff(times) > 0).all()
    assert all(np.isfinite(outcome.truth.centres_m).all() for outcome in episode.frames)
    assert episode.pictures


def test_a_wrong_baseline_puts_the_tracks_as_far_off_as_arithmetic_says():
    """All depths of the tracker are 5 % too great, and so are its positions' from the camera."""

    def depths(**changes):
        episode = play(Job(CALM, SEED, {"frames": 4, **changes}, System(), size_px=SIZE_PX))
        camera = episode.cameras[0]
        last = episode.frames[-1].estimates.positions_m
        return (last @ camera.R_cw.T + camera.t_cw)[:, 2]

    ratio = depths(calibration_baseline=5) / depths()
    np.testing.assert_allclose(ratio, 1.05, atol=0.02)
