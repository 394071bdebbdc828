"""recipe.json: read again, refused where it was edited; sizes and labels by name."""

import json
import shutil

import pytest
from made_dataset import SMALL, made_dataset

from pjpdaf.errors import BenchError
from scenarios.play.job import Job, System, digest_of
from scenarios.play.recipe import (
    Recipe,
    SequenceSettings,
    parse_labels,
    parse_size,
    read_recipe,
    sized,
)
from scenarios.spec.draw import perform
from scenarios.spec.names import load_scenario
from scenarios.spec.scenario import digest
from sim.scene.rig import stereo_rig

JOB = Job(load_scenario("drink"), 3, {"frames": 5, "noise_sd": 2.5}, System(), label="drink+noise")
RECIPE = Recipe(JOB, SequenceSettings(("seg", "depth"), (96, 72)), rung="noise")


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
        (
            {"settings": {"labels": ["x"], "size_px": None}},
            "settings.labels x: no such label; known: all, amodal, clean",
        ),
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
    with pytest.raises(BenchError, match="--labels masks: no such label; known: all, amodal"):
        parse_labels("masks")


def stored(recipe=RECIPE, **changes):
    return json.loads(json.dumps({**recipe.record(redrawn=0), **changes}))


def test_what_is_written_is_read_again(tmp_path):
    again = read_recipe(stored(), tmp_path)
    assert digest_of(again.job) == digest_of(JOB)
    assert (again.job.name, again.job.seed, again.job.overrides) == (
        "drink+noise",
        3,
        {"frames": 5, "noise_sd": 2.5},
    )
    assert again.settings == SequenceSettings(("depth", "seg"), (96, 72))
    assert again.rung == "noise"
    assert stored(again) == stored(Recipe(JOB, again.settings, "noise"))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"seed": True}, "seed must be a whole number"),
        ({"overrides": {"frames": [5]}}, "overrides must be numbers and texts"),
        ({"label": ""}, "label must be a text"),
        ({"settings": {"labels": ["seg"]}}, "settings must have labels and size_px"),
        ({"scenario": {"name": "drink"}}, "scenario must be a scenario"),
    ],
)
def test_a_recipe_of_other_types_is_one_line(tmp_path, changes, message):
    with pytest.raises(BenchError) as caught:
        read_recipe(stored(**changes), tmp_path)
    assert message in str(caught.value)
    assert str(tmp_path / "recipe.json") in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("size_px", [(160, 120), (64, 48), (1280, 960)])
def test_a_size_changes_the_pixels_and_not_the_angle_of_view(size_px):
    whole = perform(JOB.scenario, JOB.seed, JOB.overrides)
    small = sized(whole, size_px)
    before, after = (stereo_rig(p.scene.rig).cameras[0] for p in (whole, small))
    assert (after.width_px, after.height_px) == size_px
    assert after.K[0, 0] / after.width_px == pytest.approx(before.K[0, 0] / before.width_px)
    assert sized(whole, None) is whole
