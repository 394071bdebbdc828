"""Scenarios as records: digests, standard parameters, pickling."""

from __future__ import annotations

import pickle

from scenarios.spec.names import load_scenario, scenario_names
from scenarios.spec.scenario import Scenario, digest
from scenarios.spec.standard import STANDARD


def test_the_digest_is_of_the_content():
    scenario = load_scenario("cross")
    again = Scenario.model_validate(scenario.model_dump())
    assert digest(again) == digest(scenario)
    assert len(digest(scenario)) == 64
    changed = scenario.model_copy(update={"version": 99})
    assert digest(changed) != digest(scenario)
    assert len({digest(load_scenario(n)) for n in scenario_names()}) == len(scenario_names())


def test_standard_parameters_are_part_of_every_scenario():
    for name in scenario_names():
        assert load_scenario(name).parameters.keys() >= STANDARD.keys()


def test_scenarios_travel_to_workers():
    scenario = load_scenario("drink")
    assert digest(pickle.loads(pickle.dumps(scenario))) == digest(scenario)
