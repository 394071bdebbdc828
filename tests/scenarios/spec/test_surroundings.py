"""Varied surroundings: who draws what, over which ranges, and what stays nominal."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import kstest

from pjpdaf.errors import BenchError
from scenarios.play.targets import expand_target
from scenarios.spec.draw import concrete, in_si, perform
from scenarios.spec.in_view import sees_workspace
from scenarios.spec.names import load_scenario, scenario_names
from scenarios.spec.parameters.choice import Choice
from scenarios.spec.scenario import Scenario, canonical, digest, in_varied_surroundings
from scenarios.spec.standard import STANDARD
from scenarios.spec.surroundings import PARAMETERS, RIG, ROOM_CHOICES, surroundings_of
from sim.families.registry import FAMILIES


def varied(name="drink", rooms="here"):
    return in_varied_surroundings(load_scenario(name), rooms)


def test_a_nominal_scenario_knows_nothing_of_surroundings():
    for name in scenario_names():
        scenario = load_scenario(name)
        assert "surroundings" not in canonical(scenario)
        assert "rooms" not in scenario.model_dump(mode="json")
        assert not scenario.parameters.keys() & (PARAMETERS.keys() - STANDARD.keys())
    assert surroundings_of(concrete(load_scenario("drink"), 0)) is None


def test_a_varied_scenario_is_another_one_and_can_be_read_back():
    scenario = varied()
    assert digest(scenario) != digest(load_scenario("drink"))
    again = Scenario.model_validate(scenario.model_dump(mode="json"))
    assert digest(again) == digest(scenario)
    assert digest(varied(rooms="there")) != digest(scenario)
    assert concrete(again, 4) == concrete(scenario, 4)


def test_no_family_has_a_parameter_of_the_room():
    room = PARAMETERS.keys() - STANDARD.keys()
    for kind, family in FAMILIES.items():
        assert not room & set(family.parameters), kind


def test_what_a_scenario_gives_itself_stays():
    own = load_scenario("lean_and_reach").parameters["rig_tilt"]
    assert own != STANDARD["rig_tilt"]
    assert varied("lean_and_reach").parameters["rig_tilt"] == own


def test_every_draw_is_within_its_range_and_its_rig_sees_the_person():
    scenario = varied("calm_table")
    for seed in range(60):
        values = concrete(scenario, seed)
        for name, value in values.items():
            scenario.parameters[name].check(name, value)
        assert sees_workspace(in_si(scenario, values))


def test_person_and_light_are_spread_evenly_over_their_whole_range():
    drawn = [concrete(varied(), seed) for seed in range(150)]
    for name in ("stature", "skin_ita", "light_temperature", "room_depth"):
        low, high = PARAMETERS[name].range
        shares = [(values[name] - low) / (high - low) for values in drawn]
        # At 150 draws an even spread passes this in all but one of 10,000 names.
        assert kstest(shares, "uniform").statistic < 0.18, name
    for name in RIG:
        shares = [values[name] for values in drawn]
        low, high = PARAMETERS[name].bounds
        assert np.ptp(shares) > 0.85 * (high - low), name
    for name, options in ROOM_CHOICES.items():
        weights = PARAMETERS[name].weights
        likely = {option for option, weight in zip(options, weights, strict=True) if weight}
        assert {values[name] for values in drawn} == likely, name


def test_setting_a_parameter_moves_no_other_draw():
    scenario = varied()
    plain, changed = concrete(scenario, 3), concrete(scenario, 3, {"wall": "brick", "plants": 1})
    assert {k for k in plain if plain[k] != changed[k]} <= {"wall", "plants"}


def test_twins_share_their_motion_and_no_room():
    cross, bounce = (
        concrete(planned.scenario, 1)
        for planned in expand_target("varied")
        if planned.label in ("cross", "bounce")
    )
    shared = cross.keys() & bounce.keys()
    assert {name for name in shared if cross[name] == bounce[name]} >= {"speed", "wait"}
    numbers = [n for n in PARAMETERS if not isinstance(PARAMETERS[n], Choice)]
    assert not [name for name in numbers if cross[name] == bounce[name]]


def test_a_rig_that_is_set_by_hand_is_kept_though_it_sees_nothing():
    changed = {"rig_tilt": 0.0, "rig_height": 1.6, "focal": 700.0, "rig_distance": 1.1}
    values = concrete(varied(), 0, changed)
    assert {name: values[name] for name in changed} == changed


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"surroundings": "varid"}, "Input should be 'nominal' or 'varied'"),
        ({"rooms": "here"}, "goes with `surroundings: varied`"),
    ],
)
def test_words_that_are_none(changes, message):
    fields = load_scenario("drink").model_dump(mode="json") | changes
    with pytest.raises(ValueError, match=message):
        Scenario.model_validate(fields)


def test_a_value_that_no_room_has_is_one_line():
    with pytest.raises(BenchError) as fault:
        concrete(varied(), 0, {"wall": "bricks"})
    assert str(fault.value).startswith("wall: must be one of paint, wallpaper, brick, panel, got")
    assert str(fault.value).endswith("did you mean brick?")


def test_every_shipped_scenario_can_be_performed_in_varied_surroundings():
    for name in scenario_names():
        played = perform(varied(name, name), 1, {"frames": 6})
        assert played.scene.room.surroundings is not None, name
