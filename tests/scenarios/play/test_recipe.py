"""recipe.json: read again, refused where it was edited; sizes and labels by name."""

import json
import shutil

import pytest
from made_dataset import SMALL, made_dataset

from pjpdaf.errors import BenchError
from scenarios.play.job import Job
from scenarios.play.recipe import Recipe, parse_labels, parse_size, read_recipe
from scenarios.spec.scenario import digest


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    return made_dataset(tmp_path_factory)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"seed": -1}, "seed must be a whole number"),
        ({"seed": 5}, "its digest is not that of its scenario"),
        ({"overrides": {"speed": "1"}}, "has no parameter 'speed'"),
        ({"kind": "x"}, "is not a recipe of version 1"),
        ({"settings": {"labels": ["x"], "size_px": None}}, "settings.labels x: must be of clean"),
        ({"settings": {"labels": [], "size_px": [1, 10**9]}}, "both must be from 32 to 4096"),
        ({"files": {"clip": {"name": "../../x.csv", "sha256": ""}}}, "must lie in the folder"),
        (
            {"files": {}, "overrides": {"clip": "/etc/hosts.csv"}},
            "overrides.clip: its file is not among files",
        ),
        ({"overrides": {"clip": "/etc/hosts.csv"}}, "its digest is not that"),
    ],
)
def test_a_recipe_that_was_edited_is_one_line(made, tmp_path, change, message):
    folder = tmp_path / "seq"
    shutil.copytree(made / "seq_000002", folder)
    record = json.loads((folder / "recipe.json").read_text())
    record |= change
    with pytest.raises(BenchError, match=r"recipe\.json") as caught:
        read_recipe(record, folder)
    assert "\n" not in str(caught.value)
    assert message in str(caught.value)


def test_a_recipe_of_a_scenario_of_ones_own_needs_nothing_else(made, tmp_path):
    """As if its catalogue had changed since: the scenario in the recipe counts."""
    folder = tmp_path / "seq"
    shutil.copytree(made / "seq_000002", folder)
    record = json.loads((folder / "recipe.json").read_text())
    known = read_recipe(record, folder).job
    scenario = known.scenario.model_copy(update={"summary": "One's own."})
    own = Recipe(Job(scenario, known.seed, known.overrides, known.system), SMALL)
    written = json.loads(json.dumps(own.record(0)))
    assert digest(read_recipe(written, folder).job.scenario) == digest(scenario)
    shutil.rmtree(folder / "files")
    with pytest.raises(BenchError, match=r"files\.clip: no such file"):
        read_recipe(written, folder)
    with pytest.raises(BenchError, match=r"scenario\.parameters\.clip"):
        read_recipe(written | {"files": {}}, folder)
    written["scenario"]["summary"] = "Edited."
    with pytest.raises(BenchError, match=r"files\.clip|its scenario is not the one"):
        read_recipe(written, folder)


@pytest.mark.parametrize("words", ["12", "0x5", "axb", "64x", "64x5000", "-64x64", "1e3x64"])
def test_a_size_that_is_none_is_one_line(words):
    with pytest.raises(BenchError, match="--size"):
        parse_size(words)


def test_the_size_that_scenarios_have_is_no_change():
    assert parse_size("640x480") is None
    assert parse_size("320x240") == (320, 240)


def test_labels_are_named_in_any_order():
    assert parse_labels("seg,depth") == ("depth", "seg")
    assert parse_labels("none") == ()
    assert "float" in parse_labels("all")
    with pytest.raises(BenchError, match="--labels masks: must be of clean, depth"):
        parse_labels("masks")
