"""`dataset verify` as a user meets it: lines, a verdict, an exit code."""

import json
import shutil

import pytest
from shared import copied

from pjpdaf.errors import BenchError
from scenarios.dataset.check_recipes import recipe_faults
from scenarios.dataset.rays import compare_with_rays
from scenarios.dataset.verify import VerifyRequest, verify_dataset
from scenarios.play.job import Job, System
from scenarios.play.recipe import Recipe, SequenceSettings
from scenarios.spec.names import load_scenario
from sim.dataset.files.manifest import SequenceEntry, manifest_record, write_manifest
from sim.dataset.writer import write_sequence
from sim.sequence import Simulation

SEQ = "seq_000000"


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    folder = tmp_path_factory.mktemp("made") / "set"
    (folder / SEQ).mkdir(parents=True)
    scenario = load_scenario("cross")
    job = Job(scenario, 161, {"frames": 5, "fps": 1, "background_frames": 1}, System())
    recipe = Recipe(job, SequenceSettings(("seg", "depth"), (320, 240)))
    performance = recipe.performance()
    record = recipe.record(performance.redrawn)
    with Simulation(performance) as simulation:
        write_sequence(simulation, folder / SEQ, recipe.settings.labels, record)
    entry = SequenceEntry(
        SEQ, "cross", record["label"], scenario.group, 161, "", record["digest"], 5, performance.fps
    )
    write_manifest(folder, manifest_record([entry], recipe.settings.record(), {}, complete=True))
    return folder


copy = copied("made")


def test_a_whole_data_set_passes_and_says_how_exact_it_is(made, capsys):
    assert verify_dataset(VerifyRequest(made, rays=2)) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.partition(":")[0] for line in lines[:3]] == ["rays"] * 3
    assert lines[-1] == f"{made}: 1 sequence, no fault"
    cast = compare_with_rays(made, 2)
    assert cast.figures is not None
    assert cast.figures.met
    assert cast.figures.pixels == 2 * 2 * 320 * 240
    assert not cast.faults
    assert not cast.refused


def test_faults_are_lines_and_exit_code_1(copy, capsys):
    (copy / SEQ / "right" / "000003.png").unlink()
    assert verify_dataset(VerifyRequest(copy, sums=False, rays=1)) == 1
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == f"{SEQ}/right/000003.png: missing"
    assert lines[1] == f"not compared with rays: {SEQ}: has faults"
    assert lines[-1] == f"{copy}: 1 sequence, 1 fault"


def test_labels_that_agree_with_each_other_but_not_with_the_recipe_are_found(copy):
    """Whole files of one frame are put in the place of another's: only rays can tell."""
    for kind in ("seg", "depth"):
        for camera in ("left", "right"):
            folder = copy / SEQ / f"{kind}_{camera}"
            shutil.copy(folder / "000001.png", folder / "000005.png")
    cast = compare_with_rays(copy, 5)
    assert [fault.file for fault in cast.faults] == [SEQ]
    assert "is not what its recipe makes" in cast.faults[0].text


def test_a_recipe_that_cannot_be_made_is_said(copy):
    path = copy / SEQ / "recipe.json"
    record = json.loads(path.read_text())
    record["seed"] = 162
    path.write_text(json.dumps(record))
    cast = compare_with_rays(copy, 1)
    assert cast.figures is None
    assert "digest" in cast.refused[0]


@pytest.mark.parametrize(
    ("change", "text"),
    [
        (lambda r: r["scenario"].update(summary="Mine."), "its scenario is not the one"),
        (lambda r: r["overrides"].update(frames=6), "its digest is not that"),
        (lambda r: r["scenario"]["parameters"]["exposure"].update(unit=["EV"]), "exposure.numeric"),
        (lambda r: r.update(label=["cross"]), "label must be a text"),
        (lambda r: r["settings"].update(labels=[["seg"]]), "settings must have labels"),
        (lambda r: r.update(files=["x"]), "files must be names and digests"),
    ],
)
def test_an_edited_recipe_is_a_fault_though_nothing_is_compared_with_rays(copy, change, text):
    path = copy / SEQ / "recipe.json"
    record = json.loads(path.read_text())
    change(record)
    path.write_text(json.dumps(record))
    (fault,) = recipe_faults(copy)
    assert fault.file == f"{SEQ}/recipe.json"
    assert text in fault.text
    assert recipe_faults(copy, {fault.file}) == []


def test_a_recipe_of_another_version_is_not_judged(copy, capsys):
    path = copy / SEQ / "recipe.json"
    record = json.loads(path.read_text())
    record["scenario"]["summary"] = "Mine."
    path.write_text(json.dumps(record))
    assert verify_dataset(VerifyRequest(copy, sums=False, rays=0)) == 1
    assert "was edited" in capsys.readouterr().out
    record["made_with"] = {"versions": {"pjpdaf-bench": "0.0.1"}}
    path.write_text(json.dumps(record))
    assert recipe_faults(copy) == []


def test_no_data_set_and_wrong_numbers_are_refused(tmp_path, made):
    with pytest.raises(BenchError, match="is not a data set"):
        verify_dataset(VerifyRequest(tmp_path))
    with pytest.raises(BenchError, match="--rays must be 0 or more"):
        verify_dataset(VerifyRequest(made, rays=-1))
