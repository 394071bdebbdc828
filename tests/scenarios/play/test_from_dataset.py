"""`run --from`: a data set is played as the live run was, without a renderer."""

import json
import os
import shlex
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import cv2
import pytest
from commands import in_this_process
from shared import shared

import sim.dataset
from pjpdaf.errors import BenchError
from reports.gate.gate import compare
from reports.gate.replay import replay_command
from reports.run.load import load
from reports.run.rows import rows_of
from reports.run.save import RunInfo, save
from reports.run.tables import tables_of
from scenarios.execute.episodes import PlayResults
from scenarios.play.job import Job, System, digest_of
from scenarios.play.plan import PlanRequest, plan
from scenarios.play.play import play_complete
from scenarios.play.recipe import Recipe, SequenceSettings
from scenarios.run.save_run import save_run, scenario_record
from scenarios.spec.names import load_scenario
from sim.dataset.files.layout import sequence_name
from sim.dataset.files.manifest import SequenceEntry, manifest_record, write_manifest
from sim.dataset.writer import write_sequence
from sim.sequence import Simulation

ROOT = Path(__file__).parents[3]
SIZE_PX = (320, 240)


def job(name, seed, label="", **overrides):
    values = {"background_frames": 10, **overrides}
    return Job(load_scenario(name), seed, values, System(), label=label)


# A rung of a ladder; pictures that are lost, and a calibration with an error.
JOBS = (
    job("cross", 101, frames=5),
    job("cross", 102, "cross+noise", frames=4, noise_sd=4.0, dropped=10, calibration_baseline=2.0),
)


def make(folder, jobs, size_px=SIZE_PX):
    """A data set of these episodes, pictures and truth only."""
    folder.mkdir()
    entries = []
    for index, one in enumerate(jobs):
        recipe = Recipe(one, SequenceSettings((), size_px))
        target = folder / sequence_name(index)
        target.mkdir()
        with Simulation(recipe.performance()) as simulation:
            write_sequence(simulation, target, (), recipe.record(simulation.redrawn))
        name, frames = one.scenario.name, int(one.overrides["frames"])
        entries.append(
            SequenceEntry(
                target.name,
                name,
                one.name,
                one.scenario.group,
                one.seed,
                "",
                digest_of(one),
                frames,
                one.scenario.fps,
            )
        )
    made_with = {"renderer": "the renderer that made it"}
    settings = {"labels": [], "size": size_px and list(size_px)}
    write_manifest(folder, manifest_record(entries, settings, made_with, complete=True))
    return folder


def made_of_jobs(tmp_path_factory):
    """The data set of JOBS, made once for all test processes; read only."""
    return shared(tmp_path_factory, "jobs", lambda folder: make(folder / "set", JOBS)) / "set"


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    return made_of_jobs(tmp_path_factory)


@pytest.fixture
def copied(made, tmp_path):
    return Path(shutil.copytree(made, tmp_path / "copy"))


def request(dataset, **changes):
    return PlanRequest(dataset=dataset, **{"keep_pictures": True, **changes})


@pytest.fixture(scope="module")
def live():
    return [
        rows_of(play_complete(replace(one, keep_pictures=True, size_px=SIZE_PX))) for one in JOBS
    ]


@pytest.fixture(scope="module")
def kept(made):
    return [rows_of(play_complete(one)) for one in plan(request(made))]


def test_every_table_is_that_of_the_live_run(live, kept):
    one, other = tables_of(live), tables_of(kept)
    assert one["frames"].num_rows == 3 * (5 + 4)
    for name, table in one.items():
        # pandas takes NaN for equal to NaN, Arrow does not.
        assert table.to_pandas().equals(other[name].to_pandas()), name
    assert [row.pictures for row in live] == [row.pictures for row in kept]
    assert [row.truth for row in live] == [row.truth for row in kept]
    assert "cross+noise" in other["frames"]["scenario"].to_pylist()


def test_compare_takes_both_for_the_same(live, kept, made, tmp_path):
    entries = {one.name: scenario_record(one) for one in JOBS}
    jobs = plan(request(made))
    assert {one.name: scenario_record(one) for one in jobs} == entries
    saved = [
        load(save(tmp_path / name, rows, RunInfo(name, entries=entries)))
        for name, rows in (("live", live), ("kept", kept))
    ]
    verdict = compare(*saved)
    assert verdict.identical
    assert verdict.episodes == 2


SCRIPT = """
import sys
from pathlib import Path
from scenarios.play.plan import PlanRequest
from scenarios.run.request import RunRequest
from scenarios.run.run import run_suite
out, jobs, dataset = sys.argv[1:]
plan = PlanRequest(keep_pictures=True, keep_films=True, dataset=Path(dataset))
run_suite(RunRequest(plan, jobs=int(jobs), out=Path(out)))
"""


@pytest.mark.long
def test_a_whole_run_needs_no_renderer(made, live, tmp_path):
    blocked = tmp_path / "blocked"
    blocked.mkdir()
    for name in ("mujoco", "OpenGL"):
        (blocked / f"{name}.py").write_text("raise ImportError('blocked')")
    path = os.pathsep.join([str(blocked), str(ROOT)])
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT, str(tmp_path / "run"), "1", str(made)],
        env={**os.environ, "PYTHONPATH": path, "MUJOCO_GL": "disabled"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    saved = load(tmp_path / "run")
    assert saved.frames.equals(tables_of(live)["frames"].to_pandas())
    assert saved.meta["provenance"]["renderer"] == "the renderer that made it"
    assert [film["whole"] for film in saved.meta["films"]] == [True, True]
    assert saved.meta["pictures"]
    assert (tmp_path / "run/report.html").stat().st_size > 100_000


def test_its_play_it_again_command_works_as_it_is_pasted(made, kept, tmp_path):
    played = PlayResults(tuple(kept), interrupted=False, renderers=frozenset())
    saved = save_run(request(made), plan(request(made)), played, tmp_path / "run", slim=True)
    command = shlex.split(replay_command(saved.meta, "cross+noise", 102))
    done = in_this_process(*command[1:], "--slim", "--jobs", 1, "--out", tmp_path / "again")
    assert done.returncode == 0, done.stderr
    again = load(tmp_path / "again")
    assert again.digests == {("cross+noise", 102): saved.digests["cross+noise", 102]}
    mine = load(tmp_path / "run").episodes
    mine = mine[mine["scenario"] == "cross+noise"].reset_index(drop=True)
    assert again.episodes.equals(mine)


def test_only_and_slim_and_films(made):
    (one,) = plan(request(made, only=("cross+noise",), keep_pictures=False))
    assert (one.name, one.seed) == ("cross+noise", 102)
    assert not one.keep_pictures
    assert not one.keep_film
    assert all(one.keep_film and one.keep_pictures for one in plan(request(made, keep_films=True)))


def test_seeds_choose_among_the_sequences(made):
    assert [one.seed for one in plan(request(made, first_seed=102))] == [102]
    assert [one.seed for one in plan(request(made, first_seed=101, seeds=1))] == [101]
    assert [one.seed for one in plan(request(made, seeds=103))] == [101, 102]


def test_another_tracker_gives_another_result_on_the_same_pictures(made, kept):
    changed = plan(request(made, detector="thesis", tracker="thesis", only=("cross",)))
    (row,) = [rows_of(play_complete(one)) for one in changed]
    assert row.digest == kept[0].digest
    assert row.truth == kept[0].truth
    assert row.frames["error_mm"] != kept[0].frames["error_mm"]


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"settings": ("noise_sd=4",)}, "--set noise_sd does not go with --from"),
        ({"seeds": 3}, "no sequence has such a seed; it has 101 to 102; see --first-seed"),
        ({"first_seed": 103}, "no sequence has such a seed; it has 101 to 102"),
        ({"targets": ("smoke",)}, "smoke does not go with --from"),
        ({"only": ("cros",)}, "--only cros: not in it; did you mean cross?"),
        ({"tracker": "nobody"}, "nobody"),
        ({"settings": ("tracker.gat=4",), "tracker": "thesis"}, "gat"),
        ({"dataset": Path("nowhere")}, "nowhere: no such data set"),
    ],
)
def test_what_does_not_fit_is_one_line_before_anything_is_played(made, changes, said):
    with pytest.raises(BenchError) as caught:
        plan(replace(request(made), **changes))
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


def changed(path, **values):
    path.write_text(json.dumps({**json.loads(path.read_text()), **values}))


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"schema": 2}, "is not a recipe of version 1"),
        ({"scenario": {"name": "gone"}}, "scenario must be a scenario"),
        ({"overrides": {"frames": 7}}, "its digest is not that of"),
        ({"label": "another"}, "its label is 'another', in the manifest it is 'cross'"),
    ],
)
def test_a_recipe_that_cannot_be_resolved_is_one_line(copied, values, said):
    path = copied / "seq_000000/recipe.json"
    changed(path, **values)
    with pytest.raises(BenchError) as caught:
        plan(request(copied))
    assert str(caught.value).startswith(f"{path}: ")
    assert said in str(caught.value)


def test_one_episode_twice_is_refused(copied):
    first = copied / "seq_000000"
    shutil.copytree(first, copied / "seq_000002")
    manifest = json.loads((copied / "manifest.json").read_text())
    manifest["sequences"].append({**manifest["sequences"][0], "folder": "seq_000002"})
    (copied / "manifest.json").write_text(json.dumps(manifest))
    with pytest.raises(BenchError, match="has cross seed 101 twice"):
        plan(request(copied))


def test_a_damaged_picture_is_named(copied):
    path = copied / "seq_000001/right/000003.png"
    path = path if path.exists() else copied / "seq_000001/left/000003.png"
    path.write_bytes(path.read_bytes()[:-40])
    with pytest.raises(BenchError, match=rf"{path.name}: is a damaged PNG"):
        play_complete(plan(request(copied))[1])


def test_pictures_of_another_size_are_another_episode(tmp_path):
    small = make(tmp_path / "small", [job("cross", 101, frames=2)], (160, 120))
    (one,) = plan(request(small))
    assert one.size_px == (160, 120)
    assert digest_of(one) != digest_of(job("cross", 101, frames=2))
    episode = play_complete(one)
    assert episode.digest == digest_of(one)
    assert (episode.cameras[0].width_px, episode.cameras[0].height_px) == (160, 120)


def test_the_pictures_are_really_read(copied):
    """So that a renderer in disguise would show."""
    for path in (copied / "seq_000000/left").iterdir():
        picture = cv2.imread(str(path))
        cv2.imwrite(str(path), picture * 0)
    before = rows_of(play_complete(plan(request(copied))[0]))
    assert all(seen == "right" for seen in before.detections["view"])
    assert sim.dataset.open(copied).sequences[0].frame_count == 5
