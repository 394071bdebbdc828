"""A recipe that is written and read again is the same; an edited one is refused."""

import json

import pytest

from pjpdaf.errors import BenchError
from scenarios.play.job import Job, System, digest_of
from scenarios.play.recipe import (
    OWN_SIZE,
    Recipe,
    SequenceSettings,
    parse_labels,
    parse_size,
    read_recipe,
    sized,
)
from scenarios.spec.draw import perform
from scenarios.spec.names import load_scenario
from sim.scene.rig import stereo_rig

JOB = Job(load_scenario("drink"), 3, {"frames": 5, "noise_sd": 2.5}, System(), label="drink+noise")
RECIPE = Recipe(JOB, SequenceSettings(("seg", "depth"), (96, 72)), rung="noise")


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
        ({"kind": "a cake"}, "recipe of version"),
        ({"seed": True}, "seed must be a whole number"),
        ({"seed": 4}, "its digest is not that of its scenario, seed and changed values"),
        ({"overrides": {"frames": [5]}}, "overrides must be numbers and texts"),
        ({"label": ""}, "label must be a text"),
        ({"settings": {"labels": ["seg"]}}, "settings must have labels and size_px"),
        ({"settings": {"labels": ["seg"], "size_px": [1, 1]}}, "both must be from 32 to 4096"),
        ({"scenario": {"name": "drink"}}, "scenario must be a scenario"),
    ],
)
def test_an_edited_recipe_is_one_line(tmp_path, changes, message):
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


def test_sizes_and_labels_of_the_command_line():
    assert parse_size("320x240") == (320, 240)
    assert parse_size("{}x{}".format(*OWN_SIZE)) is None
    assert parse_labels("seg, depth") == ("depth", "seg")
    assert parse_labels("none") == ()
    with pytest.raises(BenchError, match="must be WIDTHxHEIGHT"):
        parse_size("320")
    with pytest.raises(BenchError, match="--labels sge: must be of"):
        parse_labels("sge")
