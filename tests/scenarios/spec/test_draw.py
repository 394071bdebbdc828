"""Values drawn for a seed: their addresses, overrides, units, and the performance made of them."""

from __future__ import annotations

import hashlib
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pjpdaf.errors import BenchError
from scenarios.spec.draw import concrete, in_si, perform
from scenarios.spec.names import load_scenario, scenario_names
from scenarios.spec.parameters.distributions import Fixed, Uniform
from scenarios.spec.parameters.numeric import Numeric


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


def test_setting_a_parameter_moves_no_other_draw():
    scenario = load_scenario("drink")
    plain, changed = concrete(scenario, 3), concrete(scenario, 3, {"speed": 0.5})
    assert changed["speed"] == 0.5
    assert {k for k in plain if plain[k] != changed[k]} == {"speed"}


def test_twins_of_a_family_share_the_draws_of_the_same_name():
    cross, bounce = (concrete(load_scenario(n), 11) for n in ("cross", "bounce"))
    shared = cross.keys() & bounce.keys()
    assert {"speed", "depth_gap", "stature", "noise_sd"} <= shared
    assert all(cross[name] == bounce[name] for name in shared)


def test_the_front_hand_is_a_fair_draw():
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
    assert "known" not in str(f.value)


def test_a_negative_seed_is_refused():
    with pytest.raises(BenchError, match="seed must be 0 or more, got -1"):
        perform(load_scenario("cross"), -1)


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


def test_each_value_is_the_quantile_of_the_draw_at_its_address():
    """A second implementation: one Philox generator an address, named seed/stream/parameter."""
    scenario = load_scenario("cross")
    values = concrete(scenario, 5, redraw=2)
    for name, parameter in scenario.parameters.items():
        address = f"5/{scenario.stream}/redraw2/{name}/0"
        key = np.frombuffer(hashlib.blake2b(address.encode(), digest_size=16).digest(), "<u8")
        share = np.random.Generator(np.random.Philox(key=key)).random()
        assert values[name] == parameter.quantile(share), name


@settings(max_examples=60, deadline=None)
@given(data=st.data(), seed=st.integers(0, 1000), redraw=st.integers(0, 3))
def test_changing_any_parameters_moves_no_other_draw(data, seed, redraw):
    scenario = load_scenario(data.draw(st.sampled_from(["drink", "cross", "calm_table"])))
    names = data.draw(st.sets(st.sampled_from(sorted(scenario.parameters)), max_size=4))
    overrides = {name: scenario.parameters[name].quantile(0.9) for name in names}
    plain = concrete(scenario, seed, redraw=redraw)
    changed = concrete(scenario, seed, overrides, redraw)
    assert {name: changed[name] for name in names} == overrides
    assert {k: v for k, v in changed.items() if k not in names} == {
        k: v for k, v in plain.items() if k not in names
    }


def test_a_parameter_that_is_added_or_given_anew_moves_no_other_draw():
    scenario = load_scenario("drink")
    plain = concrete(scenario, 3)
    wider = scenario.model_copy(
        update={
            "parameters": {
                "added": Numeric(unit="m", range=(0, 1), nominal=Uniform(kind="uniform")),
                **scenario.parameters,
                "speed": Numeric(
                    unit="m/s", range=(0.1, 0.6), nominal=Fixed(kind="fixed", value=0.6)
                ),
            }
        }
    )
    changed = concrete(wider, 3)
    assert {k for k in changed if changed[k] != plain.get(k)} == {"added", "speed"}


def test_redraws_and_seeds_give_independent_values():
    scenario = load_scenario("cross")
    drawn = [concrete(scenario, seed, redraw=k) for seed in range(3) for k in range(3)]
    assert len({values["stature"] for values in drawn}) == len(drawn)


def test_twins_are_drawn_again_together():
    short = {"frames": 9}
    for seed in range(3):
        cross, bounce = (perform(load_scenario(name), seed, short) for name in ("cross", "bounce"))
        assert cross.redrawn == bounce.redrawn
