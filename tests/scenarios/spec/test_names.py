"""The shipped scenarios and suites."""

from __future__ import annotations

import pytest

from pjpdaf.errors import BenchError
from scenarios.spec.draw import perform
from scenarios.spec.names import (
    load_scenario,
    load_suite,
    resolve,
    scenario_names,
    scenarios_of,
    suite_names,
)
from scenarios.spec.parameters.distributions import Fixed
from scenarios.spec.parameters.numeric import Numeric
from scenarios.spec.scenario import Scenario
from scenarios.spec.standard import STANDARD
from scenarios.spec.suite import Suite
from scenarios.stress.families import find_family, is_own


def test_the_catalogue_has_all_scenarios_and_suites():
    assert set(scenario_names()) == {
        "calm_table", "natural_table", "one_hand_idle", "stir_and_wipe", "lean_and_reach",
        "drink", "touch_face", "phone_at_ear", "hand_behind_head",
        "cross", "bounce", "merge_and_hold", "clap", "roll_forearms", "pass_object",
        "one_view_occluder", "hand_under_table", "leave_view",
        "both_hands_to_head", "object_splits_hand", "skin_coloured_object", "bare_forearm",
        "speed_ladder", "fps_ladder", "stop_and_reverse", "fast_finish",
        "mirror", "swap_hidden", "parallel",
        "recorded",
    }  # fmt: skip
    suites = {"smoke", "core", "thesis", "fast", "occlusion", "traps", "varied"}
    assert set(suite_names()) == suites


def test_core_plays_every_scenario_and_every_nuisance():
    core = load_suite("core")
    assert {entry.scenario for entry in core.scenarios} == set(scenario_names())
    changed = {name for entry in core.scenarios for name in entry.overrides}
    off = {name for name, p in STANDARD.items() if is_nuisance(p)}
    # Part of another nuisance, a matter of degree, or drawn where it matters.
    assert off - changed <= {"flicker_rate", "lens_k2", "principal_x", "principal_y"} | {
        "calibration_rot_x", "calibration_rot_z",
    }  # fmt: skip


def is_nuisance(parameter):
    """Nominally one value, though others are possible."""
    if isinstance(parameter, Numeric):
        return isinstance(parameter.nominal, Fixed)
    return parameter.weights is not None and max(parameter.weights) == sum(parameter.weights)


@pytest.mark.parametrize("name", scenario_names())
def test_a_shipped_scenario_is_named_like_its_file_and_says_what_it_is(name):
    scenario = load_scenario(name)
    assert scenario.name == name
    assert 30 < len(scenario.summary) < 110
    assert 40 <= scenario.frames <= 150 or scenario.rates
    assert all(p.meaning for p in scenario.parameters.values())


@pytest.mark.parametrize("name", suite_names())
def test_every_entry_of_a_suite_can_be_performed(name):
    suite = load_suite(name)
    assert suite.name == name
    labels = [entry.label or entry.scenario for entry in suite.scenarios]
    assert len(set(labels)) == len(labels)
    for entry, scenario in scenarios_of(suite):
        settings = {"frames": min(entry.frames or scenario.frames, 4)}
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
            "no scenario 'drnk'; did you mean drink?; a file of your own ends in .yaml",
        ),
        (load_suite, "smok", "no suite 'smok'; did you mean smoke?"),
        (
            resolve,
            "thesi",
            "no scenario or suite 'thesi'; did you mean thesis?",
        ),
        (resolve, "zzz", "no scenario or suite 'zzz'; `pjpdaf-bench scenarios list` lists all "),
        (resolve, "", "no scenario or suite ''; `pjpdaf-bench scenarios list` lists all "),
    ],
)
def test_unknown_names_get_a_suggestion(find, word, message):
    with pytest.raises(BenchError) as fault:
        find(word)
    assert str(fault.value).startswith(message)
    assert str(fault.value).endswith("; a file of your own ends in .yaml")


def test_a_shipped_name_is_found_without_a_look_at_installed_packages(monkeypatch):
    """A look takes 4 ms, and stress asks four times a trial."""

    def looked(name):
        raise AssertionError(f"{name}: looked for among entry points")

    for module in ("scenarios.spec.names", "scenarios.stress.families"):
        monkeypatch.setattr(f"{module}.is_own_motion", looked)
    assert load_scenario("cross").name == "cross"
    assert resolve("cross").name == "cross"
    assert resolve("smoke").name == "smoke"
    assert find_family("cross").target == "cross"
    assert not is_own("cross")
