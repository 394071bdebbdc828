"""Scenarios as records: draws, overrides, units, digests."""

from __future__ import annotations

import math
import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pjpdaf.errors import BenchError
from scenarios.spec.draw import concrete, in_si, perform
from scenarios.spec.names import load_scenario, load_suite, scenario_names
from scenarios.spec.parameters import (
    Choice,
    Fixed,
    LogUniform,
    Normal,
    Numeric,
    Uniform,
    latent,
    quantity,
)
from scenarios.spec.person_and_room import skin_rgb
from scenarios.spec.scenario import Scenario, digest, suite_digest
from scenarios.spec.standard import STANDARD

NOMINALS = (
    Uniform(kind="uniform"),
    Uniform(kind="uniform", low=0.2, high=0.4),
    LogUniform(kind="log-uniform", low=0.15),
    Normal(kind="normal", mean=0.3, sd=0.1),
)


@pytest.mark.parametrize("nominal", NOMINALS, ids=lambda n: n.kind)
@given(share=st.floats(0.001, 0.999))
def test_share_undoes_at_and_values_stay_in_range(nominal, share):
    parameter = Numeric(unit="m/s", range=(0.1, 0.6), nominal=nominal)
    value = parameter.at(share)
    assert 0.1 <= value <= 0.6
    assert parameter.share(value) == pytest.approx(share, abs=1e-9)


def test_a_fixed_parameter_is_always_its_value_but_may_be_set():
    parameter = Numeric(unit="m", range=(0.2, 0.4), nominal=Fixed(kind="fixed", value=0.35))
    assert {parameter.at(s) for s in (0.0, 0.5, 0.99)} == {0.35}
    assert parameter.check("length", "30 cm") == pytest.approx(0.3)


def test_the_latent_of_the_median_is_zero_and_of_a_normal_its_z():
    wide = Numeric(unit="m", range=(-9, 9), nominal=Normal(kind="normal", mean=1.0, sd=0.5))
    assert latent(wide, 1.0) == pytest.approx(0.0, abs=1e-12)
    assert latent(wide, 1.5) == pytest.approx(1.0, abs=1e-9)


def test_choices_come_with_their_weights():
    coin = Choice(choices=("right", "left"), weights=(3, 1))
    assert [coin.at(s) for s in (0.0, 0.74, 0.76, 0.999)] == ["right", "right", "left", "left"]
    assert Choice(choices=("a", "b"), weights=(1, 0)).at(1.0) == "a"


@pytest.mark.parametrize("name", scenario_names())
def test_every_draw_of_a_shipped_scenario_is_within_its_range(name):
    scenario = load_scenario(name)
    for seed in range(40):
        for key, value in concrete(scenario, seed).items():
            scenario.parameters[key].check(key, value)


def test_draws_are_the_same_every_time_and_differ_between_seeds():
    scenario = load_scenario("cross")
    assert concrete(scenario, 7) == concrete(scenario, 7)
    assert concrete(scenario, 7) != concrete(scenario, 8)


def test_setting_one_parameter_moves_no_other_concrete():
    scenario = load_scenario("drink")
    plain, changed = concrete(scenario, 3), concrete(scenario, 3, {"speed": 0.5})
    assert changed["speed"] == 0.5
    assert {k for k in plain if plain[k] != changed[k]} == {"speed"}


def test_twins_of_a_family_share_the_draws_of_the_same_name():
    cross, bounce = (concrete(load_scenario(n), 11) for n in ("cross", "bounce"))
    shared = cross.keys() & bounce.keys()
    assert {"speed", "depth_gap", "stature", "noise_sd"} <= shared
    assert all(cross[name] == bounce[name] for name in shared)


def test_the_front_hand_is_a_fair_concrete():
    fronts = [concrete(load_scenario("cross"), seed)["front"] for seed in range(200)]
    # 200 fair throws: 100 +- 3.5 standard deviations of 7.07.
    assert 75 <= fronts.count("right") <= 125


@pytest.mark.parametrize(
    ("overrides", "message"),
    [
        ({"speed": "3"}, "speed: 3 m/s is outside its range 0.1 to 0.6 m/s"),
        ({"speed": 0.05}, "speed: 0.05 m/s is outside its range 0.1 to 0.6 m/s"),
        ({"speed": "fast"}, "speed: must be a number in m/s, got 'fast' (range 0.1 to 0.6 m/s)"),
        (
            {"speed": "0.3 s"},
            "speed: must be in m/s, cm/s, mm/s, km/h, got unit 's' (range 0.1 to 0.6 m/s)",
        ),
        ({"speed": "nan"}, "speed: must be a number in m/s, got 'nan' (range 0.1 to 0.6 m/s)"),
        ({"speed": "1e999"}, "speed: must be finite, got '1e999' (range 0.1 to 0.6 m/s)"),
        ({"speed": math.nan}, "speed: nan m/s is outside its range 0.1 to 0.6 m/s"),
        ({"speed": ""}, "speed: must be a number in m/s, got '' (range 0.1 to 0.6 m/s)"),
        ({"front": "rihgt"}, "front: must be one of right, left, got 'rihgt'; did you mean right?"),
        ({"frames": "0"}, "frames: 0 is outside its range 1 to 20000"),
        ({"frames": "2.5"}, "frames: must be a whole number from 1 to 20000, got 2.5"),
        ({"fps": "often"}, "fps: must be a number from 1 to 30, got 'often'"),
        ({"fps": "nan"}, "fps: must be a number from 1 to 30, got 'nan'"),
        ({"frames": "inf"}, "frames: must be a number from 1 to 20000, got 'inf'"),
    ],
)
def test_a_wrong_override_is_one_line_with_unit_and_range(overrides, message):
    with pytest.raises(BenchError) as fault:
        perform(load_scenario("cross"), 0, overrides)
    assert str(fault.value).startswith(message)
    assert "\n" not in str(fault.value)
    assert fault.value.exit_code == 2


def test_an_unknown_override_gets_a_suggestion_and_the_known_names():
    with pytest.raises(
        BenchError, match=r"cross has no parameter 'sped'; did you mean speed\?"
    ) as f:
        concrete(load_scenario("cross"), 0, {"sped": "0.3"})
    assert "known: arm_scale, " in str(f.value)


def test_a_negative_seed_is_refused():
    with pytest.raises(BenchError, match="seed must be 0 or more, got -1"):
        perform(load_scenario("cross"), -1)


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("0.3", "m/s", 0.3),
        ("0.3 m/s", "m/s", 0.3),
        ("0.3m/s", "m/s", 0.3),
        ("30 cm/s", "m/s", 0.3),
        ("3.6 km/h", "m/s", 1.0),
        (" 12 mm ", "m", 0.012),
        ("180 deg", "rad", math.pi),
        ("-1e-2 m", "cm", -1.0),
        ("7 1", "1", 7.0),
    ],
)
def test_quantities_carry_units(text, unit, value):
    assert quantity(text, unit) == pytest.approx(value)


@pytest.mark.parametrize(
    "text", ["", "m", "1 2", "0.3 furlong", "--1", "1e", "0x10", "٣ m", "1e999"]
)
def test_what_is_no_quantity_is_refused(text):
    with pytest.raises(ValueError, match="must be"):
        quantity(text, "m")


def test_settings_change_frames_and_rate_but_not_the_motion():
    played = perform(
        load_scenario("drink"), 0, {"frames": "20", "fps": "10", "background_frames": 3}
    )
    assert (played.frames, played.fps, played.background_frames, played.seed) == (20, 10.0, 3, 0)


def test_values_reach_the_scene_in_si_units():
    scenario = load_scenario("drink")
    values = concrete(scenario, 0, {"skin_ita": "30 deg", "focal": 500, "can_x": "40 cm"})
    assert values["skin_ita"] == 30.0
    assert in_si(scenario, values)["skin_ita"] == pytest.approx(math.radians(30))
    scene = perform(scenario, 0, {"focal": 500, "can_x": "40 cm", "table_height": 0.74}).scene
    assert scene.rig.focal_px == 500
    assert scene.room.objects[0].position_xy_m[0] == pytest.approx(0.4)
    assert scene.room.table_height_m == 0.74


def test_skin_gets_darker_with_the_typology_angle_and_stays_skin():
    tones = np.array([skin_rgb(math.radians(a)) for a in range(-50, 61, 10)])
    assert (np.diff(tones.sum(axis=1)) > 0).all()
    assert ((tones > 0.02) & (tones < 1.0)).all()
    assert (tones[:, 0] > tones[:, 1]).all()
    assert (tones[:, 1] > tones[:, 2]).all()


def test_the_digest_is_of_the_content():
    scenario = load_scenario("cross")
    again = Scenario.model_validate(scenario.model_dump())
    assert digest(again) == digest(scenario)
    assert len(digest(scenario)) == 64
    changed = scenario.model_copy(update={"version": 99})
    assert digest(changed) != digest(scenario)
    assert len({digest(load_scenario(n)) for n in scenario_names()}) == len(scenario_names())


def test_the_digest_of_a_suite_follows_its_scenarios():
    suite = load_suite("thesis")
    scenarios = {e.scenario: load_scenario(e.scenario) for e in suite.scenarios}
    first = suite_digest(suite, scenarios)
    scenarios["drink"] = scenarios["drink"].model_copy(update={"frames": 53})
    assert suite_digest(suite, scenarios) != first


def test_standard_parameters_are_part_of_every_scenario():
    for name in scenario_names():
        assert load_scenario(name).parameters.keys() >= STANDARD.keys()


def test_scenarios_travel_to_workers():
    scenario = load_scenario("drink")
    assert digest(pickle.loads(pickle.dumps(scenario))) == digest(scenario)
