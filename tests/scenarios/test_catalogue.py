"""The shipped scenarios and suites."""

from __future__ import annotations

import pytest

from pjpdaf.errors import BenchError
from scenarios.catalogue import (
    load_scenario,
    load_suite,
    resolve,
    scenario_names,
    scenarios_of,
    suite_names,
)
from scenarios.concrete import perform
from scenarios.spec import Scenario, Suite


def test_the_catalogue_has_the_first_five_scenarios_and_two_suites():
    assert {"bounce", "calm_table", "cross", "drink", "speed_ladder"} <= set(scenario_names())
    assert {"smoke", "thesis"} <= set(suite_names())


@pytest.mark.parametrize("name", scenario_names())
def test_a_shipped_scenario_is_named_like_its_file_and_says_what_it_is(name):
    scenario = load_scenario(name)
    assert scenario.name == name
    assert 30 < len(scenario.summary) < 110
    assert 40 <= scenario.frames <= 150
    assert all(p.meaning for p in scenario.parameters.values())


@pytest.mark.parametrize("name", suite_names())
def test_every_entry_of_a_suite_can_be_performed(name):
    suite = load_suite(name)
    assert suite.name == name
    for entry, scenario in scenarios_of(suite):
        settings = {} if entry.frames is None else {"frames": entry.frames}
        assert perform(scenario, 0, {**entry.overrides, **settings}).frames >= 1


def test_the_smoke_suite_plays_every_group():
    groups = {load_scenario(name).group for name in scenario_names()}
    assert {scenario.group for _, scenario in scenarios_of(load_suite("smoke"))} == groups


def test_the_thesis_suite_plays_what_mirrors_a_figure():
    marked = {name for name in scenario_names() if load_scenario(name).thesis}
    assert {scenario.name for _, scenario in scenarios_of(load_suite("thesis"))} == marked


def test_a_word_is_a_scenario_a_suite_or_a_file(tmp_path):
    assert isinstance(resolve("drink"), Scenario)
    assert isinstance(resolve("smoke"), Suite)
    with pytest.raises(BenchError, match=r"mine\.yaml: no such file"):
        resolve(str(tmp_path / "mine.yaml"))


@pytest.mark.parametrize(
    ("find", "word", "message"),
    [
        (
            load_scenario,
            "drnk",
            "no scenario 'drnk'; did you mean drink? known: bounce, calm_table, ",
        ),
        (load_suite, "smok", "no suite 'smok'; did you mean smoke? known: smoke, thesis"),
        (resolve, "thesi", "no scenario or suite 'thesi'; did you mean thesis? known: bounce, "),
        (resolve, "zzz", "no scenario or suite 'zzz'; known: bounce, "),
        (resolve, "", "no scenario or suite ''; known: bounce, "),
    ],
)
def test_unknown_names_get_a_suggestion(find, word, message):
    with pytest.raises(BenchError) as fault:
        find(word)
    assert str(fault.value).startswith(message)
    assert str(fault.value).endswith("; or give a .yaml file")
